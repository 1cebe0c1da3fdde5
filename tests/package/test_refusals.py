"""Each row of the table of refusals raises its exception with its sentence, before anything is computed."""

import re

import pytest
from refusals import LONGEST, ROWS


@pytest.mark.parametrize(("call", "error", "sentence"), ROWS, ids=[sentence[:50] for *_, sentence in ROWS])
def test_a_refusal_says_what_is_required(call, error, sentence):
    with pytest.raises(error) as refused:
        call()
    said = refused.value.args[0]
    pattern = ".*".join(re.escape(part) for part in sentence.split("<...>"))
    assert re.fullmatch(pattern, said), said
    assert len(said) <= LONGEST
    assert not re.search(r"Formula[A-Z]|--\w", said)
