"""Error codes of the C backend."""

CODES = {
    "E470": (
        "the C generator does not support this",
        "The generated C evaluates a rule exactly as the reference does, or not at all. A node of the formula that it has no"
        " exact counterpart for makes the generator refuse the rule; the message names the rule and the node. Leave the rule"
        " out (`--rule`), or evaluate it with another backend.",
    ),
    "E471": (
        "no C compiler, or nowhere to keep what it makes",
        "The C backend compiles what it generates. It asks $CC, then `cc`, `gcc`, `clang` and the package ziglang, which comes with"
        " `pip install trackmarshal[c]`; none of them is there. Or what was compiled cannot be kept, or is not loaded: the cache folder"
        " (TRACKMARSHAL_CACHE, else `~/.cache/trackmarshal`) takes nothing or is on a disk that is mounted `noexec`, or $CC compiles for another"
        " machine. With `--backend auto`, numpy then evaluates, and says so.",
    ),
    "E472": (
        "the C compiler refuses the generated code",
        "The generated code is plain C99. Where a compiler refuses it, its own words are part of the message; a compiler that"
        " $CC names may be too old, or no C compiler at all.",
    ),
    "E473": (
        "the generated C does not hold this input",
        "Generated programs allocate nothing: arrays have the capacity that they were compiled with. An input beyond the largest"
        " one, or a track that the C geometry refuses (a coordinate that is all but zero, a figure of eight that crosses itself more often"
        " than there is room for), is not evaluated at all.",
    ),
    "E474": ("the output folder cannot be written", "`compile` writes its files into the folder of `--out`, and makes it if need be. A folder in which nothing was generated, and somebody has a file by one of these names (main.c, CMakeLists.txt, report.md), is refused: it would be lost."),
    "E475": (
        "cycles that this program cannot run from",
        "`compile --cycles` writes recordings as files for the example that comes with a Supervisor in C. Vehicle and track are compiled in,"
        " so all of them have to name the same; each needs a name of its own; and the spec has to be one that can supervise.",
    ),
    "E476": (
        "messages cannot tell so much apart",
        "A Supervisor that is a process of its own takes messages of fixed length, in which a mask of 64 bits says which columns of a"
        " signal, and which lines, are there or wanted. There is no place for lanes in them. A spec with more of them runs inside another program (`compile` without"
        " --process), or without the rules that read them.",
    ),
    "E477": (
        "the Supervisor's process cannot serve so",
        "`serve` starts a generated Supervisor as a process of its own. It does not start where another one serves the same shared memory or"
        " port, where the shared memory cannot be made, where a message is too long for a datagram, or for a spec that cannot"
        " supervise. The message has the process's own words.",
    ),
}  # fmt: skip
