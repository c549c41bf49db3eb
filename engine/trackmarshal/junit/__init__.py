"""Reports of test runners in the XML that JUnit began with: those of others read, ours written.

No schema of it was ever settled, so the reader takes what pytest, GoogleTest, CTest, Jest, Node, Maven's Surefire and their like write, and refuses
what it does not know instead of taking it for a pass.
"""
