"""Rulebooks that compare candidates: violations, the order of rules, what is better, what to choose.

After Censi et al., "Liability, Ethics, and Culture-Aware Behavior Specification using Rulebooks", ICRA 2019. docs/rulebooks.md has the meaning.
"""
