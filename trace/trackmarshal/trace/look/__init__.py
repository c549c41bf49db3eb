"""What all pages have in common: colours and signs of statuses, in light and dark. Every page's own style goes on from here."""

from pathlib import Path

#: Folder of `shared.css`, for the loaders of templates.
FOLDER = Path(__file__).parent

__all__ = ["FOLDER"]
