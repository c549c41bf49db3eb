"""Every code of this room: title and explanation, for `trackmarshal explain CODE`."""

CODES: dict[str, tuple[str, str]] = {
    "T350": ("a file of another tool cannot be read", "What was to be imported is cut, empty, in another encoding, or not of the format that its name or `--format` stands for. Nothing of it was taken over."),
    "T351": ("a file of another tool is too large", "A list of requirements of more than 64 MB is taken for something else and refused before it is read."),
    "T352": ("a text has no place in the format", "XML has no control characters, a cell of CSV has an end, YAML has no halves of characters. What would come back as something else is not written."),
    "T353": ("a document type in XML", "ReqIF has no document type. With one come entities, which make a small file a large one, or read other files; so it is refused."),
    "T354": ("a file of another tool is not built as its format says", "The file can be read, but what every such file has is missing or contradicts itself. Which requirements it holds would be a guess."),
    "T355": ("a requirement that is there twice", "Two requirements with one id, in the file or in the file and in the project: links to that id would mean either."),
    "T356": ("a link out of the exchange leads nowhere", "What it leads to is neither in the file nor in the project. A link is taken over with both of its ends, or not at all."),
    "T357": ("something is not taken over", "The other tool says something that lists of requirements here have no place for, such as markup in texts, or what it works out itself. Everything else is taken over, and what is not is named."),
    "T358": ("the columns of a CSV file", "The first line names the columns, each once, and every further line has as many cells."),
    "T359": ("a package for ReqIF is missing", "ReqIF is read and written by the package `reqif`, an extra of its own, so that nobody has to install it who does not need it."),
    "T360": ("nothing says what is to be written or read", "The format follows from the end of the file's name, or from `--format`; a file holds one list of requirements, a folder several; and fields have the names that docs/exchange.md lists."),
    "T365": ("requirements lose something when they are written over", "What is taken over replaces a file of the project that holds more: requirements that the other tool does not have any more or demands no longer, a higher ASIL, links, methods or other fields, or where a list comes from. With `--force` it is written over all the same, so each of them is named; a field in which many lose something is named once. A file that is there and is no list of requirements, such as the V-model, is not written over at all."),
    "T366": ("SOURCE_DATE_EPOCH is no time", "It says when a file is made, so that the same requirements are the same bytes on another day: whole seconds since 1970. A file with another day in it would be a guess, so none is written."),
}  # fmt: skip
