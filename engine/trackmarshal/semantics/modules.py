"""Spec files to modules: which file a `use` means, and an order in which each module follows what it uses."""

from __future__ import annotations

import os
import re
import sys
import unicodedata
from collections.abc import Iterable
from pathlib import Path
from weakref import WeakValueDictionary

import trackmarshal.prelude
from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import below, fetching
from trackmarshal.library import INSTALLED, LIBRARY
from trackmarshal.node import Node
from trackmarshal.semantics.errors.names import ImportCycle, ModuleName, ModuleNotFound
from trackmarshal.source import TEXT, SourceFile, Span, of_text, read
from trackmarshal.syntax import ast
from trackmarshal.syntax.keywords import RESERVED
from trackmarshal.syntax.names import spelled
from trackmarshal.syntax.trees import parse_kept

_SUFFIX = ".spec"
_PRELUDE = Path(trackmarshal.prelude.__file__).parent


class LoadedModule(Node):
    """A parsed module: its dotted name, its file, the modules it uses."""

    name: str
    path: Path
    file: SourceFile
    tree: ast.Module
    uses: tuple[ast.Use, ...]
    #: Names whose declarations have errors of syntax, so that nothing more is said about their uses.
    broken: set[str]
    #: Whether all of its `use` declarations could be read.
    complete: bool


class Library:
    """The modules reachable from some files; `found` collects diagnostics, `failures` files that cannot be read."""

    def __init__(self, shown_from: Path | None = None) -> None:
        self.modules: dict[str, LoadedModule] = {}
        self.found: list[Diagnostic] = []
        self.failures: list[TrackmarshalError] = []
        self._shown_from = shown_from or Path.cwd()
        self._by_path: dict[Path, LoadedModule | None] = {}

    def load(self, paths: Iterable[Path]) -> tuple[str, ...]:
        """Load files, or all of a folder's, with what they use; the names of the modules asked for, in order."""
        names = []
        for path in paths:
            try:
                files = spec_files(path)
            except TrackmarshalError as error:
                self.failures.append(error)
                continue
            if not files:
                help_ = fetching(path) or "name a .spec file, or a folder with some"
                self.failures.append(
                    TrackmarshalError("E006", "no .spec files in this folder", file=str(path), help=help_)
                )
            for file in files:
                module = self._load_file(file)
                if module is not None:
                    names.append(module.name)
        return tuple(dict.fromkeys(names))

    def load_text(self, text: str, folder: Path | None = None) -> tuple[str, ...]:
        """Load a text with what it uses, as a file of the folder (default: the current one) would; its spans name `<text>`."""
        path = (folder or Path.cwd()) / TEXT
        try:
            file = of_text(text)
        except TrackmarshalError as error:
            self.failures.append(error)
            return ()
        module = self._with_uses(path, file)
        return () if module is None else (module.name,)

    def order(self, names: Iterable[str]) -> tuple[str, ...]:
        """All modules that these need, each after those that it uses; circles are reported and cut."""
        done: dict[str, bool] = {}
        result: list[str] = []
        for root in names:
            path: list[str] = []
            stack: list[tuple[str, int]] = [(root, 0)]
            while stack:
                name, step = stack.pop()
                if step == 0:
                    if name in done:
                        continue
                    done[name] = False
                    path.append(name)
                uses = self.modules[name].uses
                if step < len(uses):
                    stack.append((name, step + 1))
                    target = uses[step]
                    if done.get(target.name) is False:
                        cycle = [*path[path.index(target.name) :], target.name]
                        hint = "move what both need into a module of its own"
                        if target.name == name:
                            hint = "remove it: a module sees its own names"
                        self.found.append(ImportCycle(target.span, " -> ".join(cycle), hint))
                    elif target.name in self.modules:
                        stack.append((target.name, 0))
                else:
                    done[name] = True
                    path.pop()
                    result.append(name)
        return tuple(result)

    def _shown(self, path: Path) -> str:
        if path.is_relative_to(_PRELUDE):
            return f"prelude/{path.name}"
        resolved = _real(path)
        if resolved.is_relative_to(self._shown_from):
            return str(resolved.relative_to(self._shown_from))
        if resolved.is_relative_to(LIBRARY):
            return str(Path("library", resolved.relative_to(LIBRARY)))
        return str(path)

    def _load_file(self, path: Path) -> LoadedModule | None:
        return self._with_uses(path, None)

    def _with_uses(self, path: Path, file: SourceFile | None) -> LoadedModule | None:
        """The module of a path, or of a file that was read already, and all that it uses."""
        pending: list[tuple[Path, SourceFile | None]] = [(path, file)]
        used: list[tuple[ast.Use, Path]] = []
        while pending:
            current, own = pending.pop()
            if _real(current) in self._by_path:
                continue
            module = self._read(current, own)
            self._by_path[_real(current)] = module
            if module is None:
                continue
            root = root_of(module)
            for use in module.uses:
                target = found_module(use.name, root)
                if target.is_file():
                    pending.append((target, None))
                    used.append((use, target))
                else:
                    self._missing(use, target, root)
        for use, target in used:
            self._misnamed(use, target)
        return self._by_path[_real(path)]

    def _read(self, path: Path, file: SourceFile | None) -> LoadedModule | None:
        try:
            file = read(path, self._shown(path)) if file is None else file
        except TrackmarshalError as error:
            self.failures.append(error)
            return None
        tree, found = _parsed(file)
        self.found += found
        names = [item for item in tree.items if isinstance(item, ast.ModuleName)]
        top = Span(file, 0, min(len(file.text), 1))
        broken = _broken(file, tree) if found else []
        keywords = {keyword for _, keyword in broken}
        if not names:
            if "module" not in keywords:
                hint = f"start it with `module {'NAME' if file.path == TEXT else _as_name(path.stem)}`"
                self.found.append(ModuleName(top, "the file does not say which module it is", hint))
            name = path.stem
        else:
            name = names[0].name
            for extra in names[1:]:
                self.found.append(
                    ModuleName(extra.span, "a file holds one module", "remove this line", names[0].span)
                )
            if tree.items[0].__dict__["span"].start < names[0].span.start:
                self.found.append(
                    ModuleName(names[0].span, "`module` comes first in a file", "move it to the top")
                )
        uses = tuple(item for item in tree.items if isinstance(item, ast.Use))
        declared = {
            spelled(word)
            for word, keyword in broken
            if keyword not in ("module", "use", "test", "constrain", "scale")
        }
        module = LoadedModule(name, path, file, tree, uses, declared, "use" not in keywords)
        if name in self.modules:
            other = self.modules[name]
            at, first = (_named(m.tree, Span(m.file, 0, min(len(m.file.text), 1))) for m in (module, other))
            hint = _one_of_two(name, module, other)
            self.found.append(ModuleName(at, f"two files are module `{name}`", hint, first))
            return None
        self.modules[name] = module
        return module

    def _missing(self, use: ast.Use, target: Path, root: Path) -> None:
        hint = (
            fetching(target)
            or close_matches(use.name, modules_near(root))
            or "`use a.b` reads a/b.spec, from the folder in which this module's own name starts"
        )
        self.found.append(ModuleNotFound(use.span, use.name, self._shown(target), hint))

    def _misnamed(self, use: ast.Use, target: Path) -> None:
        """Report a `use` that finds a file of another module."""
        found = self._by_path.get(_real(target))
        if found is not None and found.name != use.name:
            problem = f"{self._shown(target)} is module `{found.name}`, not `{use.name}`"
            self.found.append(
                ModuleName(
                    use.span, problem, "a module `a.b` lives in a/b.spec", _named(found.tree, use.span)
                )
            )


#: Trees without any finding, by path and text, as long as somebody has them: specs of one project use the same modules.
_TREES: WeakValueDictionary[tuple[str, str], ast.Module] = WeakValueDictionary()


def _parsed(file: SourceFile) -> tuple[ast.Module, list[Diagnostic]]:
    """The tree of a file, and what is wrong with its syntax; trees are immutable, so that one is enough for all who read the same."""
    known = _TREES.get((file.path, file.text))
    if known is not None:
        return known, []
    tree, found = parse_kept(file)
    if not found:
        _TREES[file.path, file.text] = tree
    return tree, found


_DECLARED = re.compile(r"^([A-Za-z_]\w*)[ \t]+([^\W\d][\w.-]*)", re.MULTILINE)


def _broken(file: SourceFile, tree: ast.Module) -> list[tuple[str, str]]:
    """What is named on lines in column 1 that are not in the tree, since they have errors of syntax: each name with its keyword; a rule and its tests share theirs."""
    parsed = {item.__dict__["span"].start for item in tree.items}
    return [(match[2], match[1]) for match in _DECLARED.finditer(file.text) if match.start() not in parsed]


def declared(text: str) -> dict[str, str]:
    """What the lines of a text that start in column 1 declare: name -> keyword."""
    return {spelled(match[2]): match[1] for match in _DECLARED.finditer(text)}


def _named(tree: ast.Module, otherwise: Span) -> Span:
    """Where a file says which module it is."""
    return next((item.span for item in tree.items if isinstance(item, ast.ModuleName)), otherwise)


def modules_near(root: Path) -> list[str]:
    """Names of the modules that can be used from a folder: those in it, the prelude's and the library's."""
    prelude = (f"prelude.{path.stem}" for path in _PRELUDE.glob("*.spec"))
    return list(dict.fromkeys([*_modules_below(root), *prelude, *_modules_below(LIBRARY)]))


def _modules_below(root: Path, most: int = 2000) -> list[str]:
    """Names of the modules in a folder; of the first ones found, where the folder is a large one."""
    names: list[str] = []
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        most -= len(folders) + len(files)
        names += [
            ".".join(Path(folder, f).relative_to(root).with_suffix("").parts)
            for f in files
            if f.endswith(".spec")
        ]
        if most < 0:
            break
    return names


def _one_of_two(name: str, *modules: LoadedModule) -> str:
    """What to do where two files are one module. A copy of a shipped one in a folder of another name is not found by its name: who uses the module reads
    the shipped file."""
    parts = tuple(name.split("."))
    apart = [one for one in modules if one.path.with_suffix("").parts[-len(parts) :] != parts]
    if len(apart) != 1:
        return "rename one of them"
    return f"`use {name}` reads {'/'.join(parts)}.spec: keep {apart[0].path.name} there, or rename its module"


def _as_name(stem: str) -> str:
    """The name of a module that a file's is nearest to."""
    plain = unicodedata.normalize("NFKD", stem).encode("ascii", "ignore").decode()
    name = re.sub(r"\W", "_", plain) or "NAME"
    return f"m_{name}" if name[0].isdigit() or name in RESERVED else name


def _real(path: Path) -> Path:
    """The path without symbolic links; one that leads in a circle stays as it is, and so does one that is none."""
    try:
        return Path(os.path.realpath(path))
    except ValueError:  # of a zero character
        return path


def spec_files(path: Path) -> list[Path]:
    """The `.spec` files that a path means: itself, or all below a folder, in the order of their names.

    Links to folders are followed. Raises E001 where a part of the folder cannot be looked at, E007 for a name that is almost one of a spec:
    what is left out without a word would be a rule less.
    """
    if not path.is_dir():
        return [path]
    found, problems = below(path, (_SUFFIX,))
    for problem in problems:
        raise TrackmarshalError(
            "E001",
            f"cannot be read: {problem.strerror}",
            file=os.fspath(problem.filename),
            help="every spec in the folder counts: remove what is none of it, or make it readable",
        ) from problem
    for file in found:
        if file.suffix != _SUFFIX:
            raise TrackmarshalError(
                "E007",
                f"`{file.name}` is almost the name of a spec",
                file=str(file),
                help=f"rename it to `{file.stem}{_SUFFIX}`; if it is none, give it another suffix",
            )
    return found


def root_of(module: LoadedModule) -> Path:
    """The folder in which module names start: module a.b in X/a/b.spec starts in X; else the file's own folder.

    Behind a link to a folder, the name may be the one by which the link is known.
    """
    parts = module.name.split(".")
    real = _real(module.path)
    for path in (real, Path(os.path.abspath(module.path))):
        if path.with_suffix("").parts[-len(parts) :] == tuple(parts):
            return path.parents[len(parts) - 1]
    return real.parent


def module_path(name: str, root: Path) -> Path:
    parts = name.split(".")
    if parts[0] == "prelude":
        return (
            _PRELUDE.joinpath(*parts[1:]).with_suffix(".spec")
            if len(parts) > 1
            else _PRELUDE / "prelude.spec"
        )
    return root.joinpath(*parts).with_suffix(".spec")


def found_module(name: str, root: Path) -> Path:
    """The file that a `use` reads: the one below the folder, and where there is none, the library's.

    A project's own module comes first, so it may have another vehicle or other limits by the names of the shipped ones. Modules of the
    library use each other: where both a project's module and the library's of one name are reached, the compiler says so and takes neither.
    """
    own = module_path(name, root)
    if own.is_file():
        return own
    # As if it had been opened: what is kept of specs has to hear of it when it is there one day, wherever that is.
    sys.audit("open", os.fspath(own), "r", os.O_RDONLY)
    shipped = module_path(name, LIBRARY)
    return shipped if shipped.is_file() else own


def from_prelude(module: LoadedModule) -> bool:
    """Whether a module comes with the tool."""
    return module.path.is_relative_to(_PRELUDE)


def from_library(module: LoadedModule, project: Path | None) -> bool:
    """Whether a module is a shipped one that a project uses; in the project that they are written in, they are its own."""
    path = _real(module.path)
    own = not INSTALLED and project is not None and path.is_relative_to(_real(project))
    return path.is_relative_to(LIBRARY) and not own
