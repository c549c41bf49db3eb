"""Whether a rule got weaker or stronger than the baseline holds it, by margins on all that the project recorded.

The baseline holds hashes, and git the specs that have them: those of the commit that changed the baseline last, or of HEAD. What is compared is first
held against the hashes, so that nothing is told of other specs than those that were accepted.
"""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.answers import Answers
from trackmarshal.cli.facts import Facts
from trackmarshal.errors import TrackmarshalError
from trackmarshal.records.specs import SpecItem

if TYPE_CHECKING:
    from trackmarshal.cli.sources import Sources
    from trackmarshal.comparing import Pair, RuleChange
    from trackmarshal.trace import Project
    from trackmarshal.trace.baseline import Content

#: What the comparison's words are here.
_WORDS = {"weaker": "weaker", "stricter": "stronger", "mixed": "both weaker and stronger"}
NOT_TOLD = "not told"
#: Rules that are named where several read what changed.
_NAMED = 3


class Weakening:
    """Says of what changed since the baseline, for `trace.build` and `trace.accept_baseline`, whether rules got weaker: `Tell`."""

    def __init__(
        self, root: Path, project: Project, facts: Facts, answers: Answers, sources: Sources | None
    ) -> None:
        """sources: the specs as they are; None where nothing may be run, and only what is in the store is told."""
        self._root, self._project, self._facts, self._answers, self._sources = (
            root,
            project,
            facts,
            answers,
            sources,
        )
        self._items = {item.name: item for item in reversed(facts.items)}
        self._told: dict[str, tuple[str, str]] = {}

    def __call__(self, before: Content, keys: Sequence[str]) -> dict[str, str]:
        """By name of an entry (`rule x`, `param y`), what is told of it."""
        rules = {key: [item.name for item in self._of(key) if _kind(item) in before] for key in keys}
        wanted = {name: _accepted(before, self._items[name]) for names in rules.values() for name in names}
        left = {name: inputs for name, inputs in wanted.items() if name not in self._told}
        self._tell(left, _all_rules(before))
        return {
            key: _together([(name, *self._told[name]) for name in names]) + self._kept(names)
            for key, names in rules.items()
            if names
        }

    def _of(self, key: str) -> list[SpecItem]:
        """The rules and monitors that an entry is, or that read it."""
        kind, _, name = key.partition(" ")
        if kind in ("rule", "assumption"):
            return [self._items[name]] if name in self._items else []
        return [item for item in self._items.values() if key in item.inputs]

    def _kept(self, names: Sequence[str]) -> str:
        """That runs whose recordings need not be here say nothing of it, where these rules are evaluated in some: of them verdicts are kept, and no margins."""
        found = [
            str(scenario.path)
            for scenario in self._project.scenarios
            if scenario.kept
            and not {f"rule {name}" for name in names}.isdisjoint(
                self._facts.run_inputs.get(str(scenario.path), ())
            )
        ]
        if not found:
            return ""
        more = f" and {len(found) - 1} more" if len(found) > 1 else ""
        return f"; nothing is told by the kept run of `{found[0]}`{more}, which has verdicts and no margins"

    def _tell(self, wanted: Mapping[str, Mapping[str, str]], others: str) -> None:
        """others: a hash of all rules that were accepted, since what is driven, and what rules over the run remember of it, is decided by all."""
        from trackmarshal.meaning import key, sha256, tool

        # With all that runs rest on: a scenario names its track, and rules are configured with it.
        runs = sorted(self._facts.run_inputs.items())
        recorded = sha256(*(f"{path} {key(inputs)}" for path, inputs in runs))
        rules = sha256(others, *(item.fingerprint for item in self._items.values()))
        left: dict[str, dict[str, str]] = {}
        for name, accepted in wanted.items():
            inputs = {
                "before": key(accepted),
                "rule": self._items[name].fingerprint,
                "rules": rules,
                "recording": recorded,
                "engine": tool(),
            }
            known = self._answers.known("comparison", name, inputs, False, _told)
            if known is not None:
                self._told[name] = known
            else:
                left[name] = inputs
        if not left:
            return
        for name, word, said, holds in self._compared({name: wanted[name] for name in left}):
            self._told[name] = (word, said)
            if holds:
                self._answers.learn("comparison", name, left[name], {"word": word, "said": said})
        self._answers.write()

    def _compared(self, wanted: Mapping[str, Mapping[str, str]]) -> Iterator[tuple[str, str, str, bool]]:
        """Each rule with a word, a sentence, and whether it was compared at all."""
        if self._sources is None:
            yield from ((name, NOT_TOLD, "nothing is run", False) for name in wanted)
            return
        if self._sources.broken:
            yield from ((name, NOT_TOLD, "the specs have errors", False) for name in wanted)
            return
        with tempfile.TemporaryDirectory(prefix="trackmarshal-baseline-") as folder:
            why, left = "", dict(wanted)
            commits = self._commits()
            if not commits:
                why = "git has no history of the project"
            for number, commit in enumerate(commits):
                if not left:
                    return
                there = Path(folder).resolve() / str(number)
                there.mkdir()
                then = self._then(commit, there)
                fitting = (
                    []
                    if then is None
                    else [name for name, inputs in left.items() if then.inputs(name) == inputs]
                )
                if then is not None and fitting:
                    pairs, lacking = then.pairs(self._sources)
                    for name in fitting:
                        del left[name]
                        yield (name, *_said(name, pairs, lacking, self._items[name].inputs), True)
            for name in left:
                yield name, NOT_TOLD, why or "the specs that were accepted are in no commit at hand", False

    def _commits(self) -> list[str]:
        """Where the specs that were accepted may be; none where there is no history."""
        from trackmarshal.cli.revisions import commit_of, last_change

        try:
            found = last_change(str(self._project.baseline), self._root)
            head = commit_of("HEAD", self._root)
        except TrackmarshalError:
            return []
        return [*dict.fromkeys(commit for commit in (found, head) if commit)]

    def _then(self, commit: str, folder: Path) -> _Then | None:
        """The project at a commit; None where it was none, or does not compile."""
        from trackmarshal.cli.project import MARKER
        from trackmarshal.cli.revisions import read
        from trackmarshal.cli.sources import Sources
        from trackmarshal.trace import requirements

        try:
            read(commit, self._root, folder)
            if not (folder / MARKER).is_file():
                return None
            sources = Sources(folder, requirements.load(folder, []))
        except TrackmarshalError:
            return None
        return None if sources.broken else _Then(sources)


class _Then:
    """The project as it was accepted."""

    def __init__(self, sources: Sources) -> None:
        self._sources = sources

    def inputs(self, name: str) -> dict[str, str]:
        """What a rule came to, as the baseline would hold it; empty where there was none."""
        rule = self._sources.compiled.spec.rule(name)
        found = {} if rule is None else self._sources.meaning.rule(rule)
        return {key: value for key, value in found.items() if key != "constraints"}

    def pairs(self, now: Sources) -> tuple[list[Pair], int]:
        """All recordings of the project as it is, under its rules and under those of then; and how many could not be judged."""
        from trackmarshal.cli.replay import Known, evaluator_for
        from trackmarshal.comparing import Pair, judge

        known = Known()
        pairs: list[Pair] = []
        lacking = 0
        scenarios = {str(scenario.path): scenario for scenario in now.project.scenarios if not scenario.kept}
        root, project = self._sources.root, self._sources.project
        for shown, (recording, evaluator) in now.recorded.items():
            if shown not in scenarios:
                continue  # a log that need not be here: of its kept run there are no margins
            more = [root / str(spec) for spec in scenarios[shown].specs]
            try:
                old = evaluator_for(
                    recording,
                    root / project.default_spec,
                    [],
                    root,
                    None,
                    "numpy",
                    (root / shown).parent,
                    [spec for spec in more if spec.exists()],
                    known,
                )
                pairs.append(Pair(judge(old, recording), judge(evaluator, recording)))
            except TrackmarshalError:
                lacking += 1
        return pairs, lacking


def _told(held: Mapping[str, Any]) -> tuple[str, str]:
    """Word and sentence of a comparison, of what the store holds; raises KeyError for what is none."""
    return str(held["word"]), str(held["said"])


def _kind(item: SpecItem) -> str:
    return f"{'rule' if item.kind == 'rule' else 'assumption'} {item.name}"


def _accepted(before: Content, item: SpecItem) -> dict[str, str]:
    """What a rule came to when it was accepted: its meaning, and that of all that it read."""
    entry = before[_kind(item)]
    reads = entry.get("reads", [])
    found = {f"rule {item.name}": str(entry.get("meaning", ""))}
    return found | {
        name: str(before.get(name, {}).get("says", ""))
        for name in ([reads] if isinstance(reads, str) else reads)
    }


def _all_rules(before: Content) -> str:
    """One hash of all that rules came to when they were accepted."""
    from trackmarshal.meaning import sha256

    said = {key: entry.get("meaning") or entry.get("says") for key, entry in before.items()}
    return sha256(*(f"{key} {value}" for key, value in sorted(said.items()) if value))


def _said(name: str, pairs: Sequence[Pair], lacking: int, reads: Collection[str]) -> tuple[str, str]:
    """A word, and a sentence. reads: what the rule reads, by name (`param x`)."""
    from trackmarshal.comparing import of_rule

    change = of_rule(pairs, name)
    left_out = f"; {lacking} recordings cannot be judged by both" if lacking else ""
    left_out += _hidden(pairs, reads)
    if change is None or not change.cycles:
        return NOT_TOLD, f"no recording is judged by it{left_out}"
    if change.word not in _WORDS:
        why = (
            f"no recorded cycle of {change.cycles} tells the two apart"
            if change.word == "equal"
            else "they cannot be held against each other"
        )
        return NOT_TOLD, why + left_out
    return _WORDS[change.word], _numbers(change) + left_out


def _hidden(pairs: Sequence[Pair], reads: Collection[str]) -> str:
    """That recordings show nothing of another value that the rule reads, since they have their own in place of it."""
    from trackmarshal.scenarios.overrides import hidden

    found = [
        f"`{pair.new.recording.name}`, which has {said}"
        for pair in pairs
        for name, said in hidden(pair.new.recording, pair.old.evaluator.spec, pair.new.evaluator.spec)
        if name in reads
    ]
    if not found:
        return ""
    more = f", and {len(found) - 1} more such" if len(found) > 1 else ""
    return f"; nothing is told of that by {found[0]}{more}"


def _numbers(change: RuleChange) -> str:
    from trackmarshal.comparing.render import moved

    turned = [
        f"{flip.old} is {flip.new} in {flip.cycles} cycles of {flip.recording}" for flip in change.flips
    ]
    more = f" and {len(turned) - 1} more such" if len(turned) > 1 else ""
    flips = f", {turned[0]}{more}" if turned else ", no verdict turns"
    margins = f", margins move {moved(change)}" if change.margins is not None else ""
    return f"{change.changed} of {change.cycles} recorded cycles differ{flips}{margins}"


def _together(told: Sequence[tuple[str, str, str]]) -> str:
    """What is told of one rule, or of several that read what changed."""
    if len({(word, said) for _, word, said in told}) == 1:
        _, word, said = told[0]
        return f"{word}: {said}"
    by_word: dict[str, list[str]] = {}
    for name, word, _ in told:
        by_word.setdefault(word, []).append(name)
    parts = []
    for word in (*_WORDS.values(), NOT_TOLD):
        names = by_word.get(word, [])
        if names:
            shown = ", ".join(f"`{name}`" for name in names[:_NAMED])
            more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
            parts.append(f"{word}: {shown}{more}")
    return ", ".join(parts)


__all__ = ["NOT_TOLD", "Weakening"]
