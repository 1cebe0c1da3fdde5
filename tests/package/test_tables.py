"""The tables of measurements: pages have what the writer makes of the numbers recorded, of benchmarks that exist."""

import json
import re
import sys
from pathlib import Path

import pytest

BENCH = str(Path(__file__).parents[2] / "bench")
sys.path.insert(0, BENCH)
import pages  # noqa: E402
import tables  # noqa: E402

sys.path.remove(BENCH)

RECORD = json.loads(tables.RECORD.read_text())
TABLES = list(tables.tables())


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.name)
def test_a_page_has_what_was_measured(table):
    _, block, _ = pages.between((pages.ROOT / table.page).read_text(), table.name)
    assert block == f"\n{table.text(RECORD)}\n\n"
    assert "{" not in block
    for row in table.rows:
        assert len(row.cells) == len(table.heads) - (table.heads[-1] == " command ")
        file, _, test = row.source.partition("::")
        if row.source != tables.GATE:
            assert f"def {test}(numbers" in (pages.ROOT / file).read_text()
        if row.source in RECORD["numbers"]:
            assert row.lines(RECORD["numbers"])


def test_no_table_is_without_its_marks():
    for page in {table.page for table in TABLES}:
        marks = re.findall("<!-- (.*): written by make tables -->", (pages.ROOT / page).read_text())
        assert marks == [table.name for table in TABLES if table.page == page]
