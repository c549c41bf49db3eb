"""The record of a run: every cycle as it came in, and what was decided about it, appended before the decision is returned.

An Arrow IPC stream (`arrow.py`), one batch a cycle. Columns by name:

- `row`: how many rows come before it in the file, whatever they are (records of version 2 do not say it);
- `number`, `t`: the cycle's, where they are numbers; `arrived`, `finished`: the clock's readings, NaN where there was none;
- `driving.F`, `emergency.F`, `SIGNAL.F`: what passed the door, in SI, members of enumerations by the places that the head names; borders as `SIGNAL.LINE.x` and `.y`, empty where they are those of
  the row before that has any; `SIGNAL.name`: what the track is called, empty too where it has no name;
- `raw`: JSON of the cycle as it came in, where it did not pass the door; its columns are empty then. `null` stands for no cycle;
- `left_out`: JSON of the columns that the cycle did not have, in which the spec's defaults stand, with the places of the elements of a set that did not, where others did
  (records before version 4 do not say it, those before version 5 not that a track has no name);
- `missed`: how many cycles before this one could not be written (a full disk), or were not decided as their steps were stopped; a row without a `state` is no cycle: it says only that, or has
  in `raw` a part of a snapshot (`snapshots.py`), from which a replay can start;
- the decision: `state`, `safe`, `driven`, `driven_number`, `driven_t`, `lost`, `faults` and `violations` (JSON), `verdicts.CANDIDATE` (a letter a
  rule: s, v, u, i, o) and `margins.CANDIDATE`.
"""

from trackmarshal.runtime.record.writing import Record

__all__ = ["Record"]
