"""What `export`, `import requirements` and `diff` say of arguments and files that they cannot use, word for word.

What is wrong inside a file of another tool is in tests/unit/test_exchange.py.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from trackmarshal.cli.main import main
from trackmarshal.trace import exchange

HERE = Path(__file__).parent
GOLDEN = HERE / "exchange" / "commands.txt"
HEAD = "id,title,statement,rationale,status,asil,verification,source\n"
ROW = "AB-1,A,It shall.,B,draft,QM,test,C\n"


def test_messages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    root = tmp_path / "project"
    (root / "requirements").mkdir(parents=True)
    (root / "requirements" / "v-model.yaml").write_text(
        "document: v-model\ntitle: T\nproject: {name: P, specs: [specs], default_spec: specs/a.spec}\nstages:\n  - {id: S-1, title: T, shows: T, applies_to: ['*'], counts: [rule]}\n"
    )
    monkeypatch.chdir(root)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    monkeypatch.setattr(exchange, "MAX_BYTES", 300)
    Path("in.csv").write_text(HEAD + ROW)
    Path("in.txt").write_text(HEAD + ROW)
    Path("big.csv").write_text(HEAD + ROW * 9)
    Path("half.json").write_text(
        '{"versions": {"1": {"needs": {"AB-1": {"title": "a \\ud800", "content": "a", "rationale": "b", "status": "draft", "asil": "QM", "verification": ["test"], "source": "c"}}}}}'
    )
    Path("two.csv").write_text("document," + HEAD + "a," + ROW + "b," + ROW.replace("AB-1", "AB-2"))
    Path("same.csv").write_text("document," + HEAD + "a," + ROW + "a/," + ROW.replace("AB-1", "AB-2"))
    Path("requirements/x.yaml").write_text(
        'document: requirements\ntitle: T\nrequirements:\n  - {id: AB-9, title: "a\\x01b", statement: It shall., rationale: b, status: draft, asil: QM, verification: [test], source: c}\n'
    )
    said = []
    for line in [
        "import requirements big.csv", "import requirements in.txt", "import requirements half.json", "import requirements in.csv --field nothing=A",
        "import requirements two.csv --out one.yaml", "import requirements same.csv --out folder", "import requirements in.csv --out requirements/x.yaml",
        "import requirements in.csv --out requirements/x.yaml --force", "import requirements in.csv", "export requirements", "export requirements --format needs --out out.json",
        "diff nothing . --on r.tmrec.jsonl", "diff . . --on r.tmrec.jsonl",
    ]:  # fmt: skip
        if line.startswith("import requirements in.csv --out requirements/x.yaml --force"):
            assert main(["export", "requirements", "--out", "out.reqif"]) == 2
            monkeypatch.setitem(sys.modules, "reqif.parser", None)
            assert main(["export", "requirements", "--out", "out.reqif"]) == 2
            said.append("> export requirements --out out.reqif\n" + capsys.readouterr().err)
        status = main(line.split())
        said.append(f"> {line}\n{capsys.readouterr().err}exit status {status}\n")
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    assert main(["export", "requirements", "--format", "needs"]) == 2
    said.append(
        f"> SOURCE_DATE_EPOCH=yesterday export requirements --format needs\n{capsys.readouterr().err}"
    )
    actual = "\n".join(said)
    if os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1":
        GOLDEN.write_text(actual, encoding="utf-8")
    assert actual == GOLDEN.read_text(encoding="utf-8")
    for code in ("T351", "T352", "T359", "T360", "T361", "T362", "T366"):
        assert f"error[{code}]" in actual
