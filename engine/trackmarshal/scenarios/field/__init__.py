"""A vehicle's log as a recording: by a declared mapping, with its noise, and what the rules say of it with causes."""
