"""Pictures as inline SVG. Colours and textures are classes and patterns of the page's style, so both themes fit."""
