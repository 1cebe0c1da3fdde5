"""Options of jobs beside the parameters of the functions that take them: types, defaults and texts are the same."""

import ast
import dataclasses
import inspect
import re
import textwrap

import pytest

import fastaff as fa
from fastaff.chaos.indicators import INDICATORS, indicator_names
from fastaff.jobs.analyses import ANALYSES, RunOptions
from fastaff.runs.schemes.catalogue import SCHEMES

FUNCTIONS = {
    "poincare": fa.poincare_map,
    "frequency_map": fa.frequency_map,
    "chaos_map": fa.chaos_map,
    "action_angles": fa.action_angles,
    "integrate": fa.integrate,
}
"""Functions that compute the analyses of a job."""


def helps(kind):
    """Return the texts below the fields of a class, which commands show."""
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    names = {field.name for field in dataclasses.fields(kind)}
    after = zip(tree.body, tree.body[1:])
    return {
        node.target.id: text.value.value
        for node, text in after
        if isinstance(node, ast.AnnAssign) and node.target.id in names
    }


def shared():
    """Yield each option of a job that has the name of a parameter of its function, with that parameter."""
    for table, function in FUNCTIONS.items():
        parameters = inspect.signature(function).parameters
        for kind in (ANALYSES[table], RunOptions):
            for option in dataclasses.fields(kind):
                if option.name in parameters:
                    yield pytest.param(kind, option, parameters[option.name], id=f"{table}.{option.name}")


def test_each_analysis_has_its_function():
    assert set(FUNCTIONS) == set(ANALYSES)
    assert {option.name for option in dataclasses.fields(RunOptions)} <= {*inspect.signature(fa.integrate).parameters}


@pytest.mark.parametrize(("kind", "option", "parameter"), [*shared()])
def test_an_option_is_that_of_the_function(kind, option, parameter):
    """By type and default, which the text names; only where the function has no default the job may have its own."""
    text = helps(kind)[option.name]
    named = re.findall(r"\[(.*)\]", text, re.DOTALL)
    if option.name == "indicators":
        assert tuple(INDICATORS[name] for name in indicator_names(option.default)) == parameter.default
    else:
        assert option.type.partition(" ")[0] in re.findall(r"\w+", parameter.annotation)
        assert option.default == parameter.default or parameter.default is parameter.empty
    if option.default is not dataclasses.MISSING and option.default is not None and option.default is not False:
        assert re.split("[:;]", *named)[0] == str(option.default)


def test_texts_name_the_accuracies_of_the_functions():
    text = helps(RunOptions)["accuracy"]
    found = {}
    for table, function in FUNCTIONS.items():
        if "accuracy" in inspect.signature(function).parameters:
            found[table] = re.search(r"^accuracy : float, default (\S+)$", inspect.getdoc(function), re.MULTILINE)[1]
    assert found.pop("frequency_map") in re.search(r"\[.*; (\S+) for frequencies\]", text)[1]
    assert found.keys() == {"poincare", "integrate"}
    assert {*found.values()} == {re.search(r"\[(\S+);", text)[1]}
    assert "Not for chaos maps." in text


def test_texts_name_all_methods_and_indicators():
    listed = helps(RunOptions)["scheme"].partition("[")[0]
    assert re.findall(r"[A-Z]+[A-Z0-9_]+", listed) == sorted(
        SCHEMES, key=lambda name: (SCHEMES[name].adaptive, [*SCHEMES].index(name))
    )
    listed = helps(ANALYSES["chaos_map"])["indicators"].partition(":")[2].partition("[")[0]
    assert {*re.findall(r"\w+", listed)} | {f"gali_{k}" for k in range(2, 9)} == {*INDICATORS}
