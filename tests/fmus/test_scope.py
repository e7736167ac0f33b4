"""Names, modification, redeclaration and connections have the values that the Modelica specification 3.6 defines.

Each class represents a rule; the number is worked out by hand from the rule. All classes are simulated in one FMU.
"""

import fmpy
import pytest
from corpus.case import FOLDER, paragraphs

RULES = {name: (text, float(value)) for (name, value), text in (
    (comment.split("; "), text) for comment, text in paragraphs("scope.mo")
)}  # fmt: skip


@pytest.fixture(scope="module")
def results(modelica):
    names = {rule: f"C{i}" for i, rule in enumerate(RULES)}
    classes = "\n".join(f"  model {names[rule]}\n    {text}\n  end {names[rule]};" for rule, (text, _) in RULES.items())
    components = "\n".join(f"  P.{name} {name.lower()};" for name in names.values())
    library = (FOLDER / "Scope.mo").read_text()
    fmu = modelica(library.replace("// classes", classes).replace("// components", components))
    outputs = {rule: f"{name.lower()}.y" for rule, name in names.items()}
    found = fmpy.simulate_fmu(
        str(fmu.folder), stop_time=1.0, output=list(outputs.values()), output_interval=1.0, fmi_type="CoSimulation"
    )
    return {rule: found[output][-1] for rule, output in outputs.items()}


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_of_the_specification_gives_its_value(results, rule):
    """Within 1e-6: the values are constant, but some are solved for, and some integrated by a solver of 1e-5."""
    assert results[rule] == pytest.approx(RULES[rule][1], abs=1e-6)
