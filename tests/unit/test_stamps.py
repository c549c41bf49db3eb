"""A stamp that is refused: what is said of it leads to what is wrong with it."""

from __future__ import annotations

import pytest

from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.stamps import stamp_after


@pytest.mark.parametrize(
    ("t", "last", "said", "help_"),
    [
        (None, None, "has no stamp", 'write it as "t", in s'),
        (0.5, 1_000_000_000, "does not come after the one before", "a run is in the order of its stamps"),
        (1.0, 1_000_000_000, "does not come after the one before", "a run is in the order of its stamps"),
        (1.7e18, None, "is not within 4e+09 s of 0", "stamps are finite, and in s"),
        (float("nan"), None, "is not within 4e+09 s of 0", "stamps are finite, and in s"),
        (float("inf"), 0, "is not within 4e+09 s of 0", "stamps are finite, and in s"),
    ],
)
def test_what_is_wrong_with_a_stamp_is_what_the_help_is_about(
    t: float | None, last: int | None, said: str, help_: str
) -> None:
    with pytest.raises(TrackmarshalError) as refused:
        stamp_after(Frame(t=t), last)
    assert refused.value.code == "D206"
    assert said in str(refused.value)
    assert help_ in (refused.value.help or "")
