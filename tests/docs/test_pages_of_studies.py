"""Every study is described in the documentation with its command, or is a page that its stored tables reproduce."""

import re
import sys
from contextlib import nullcontext

import pytest
from command_line import exit_code
from project_files import ROOT
from study_pages import execute, pages

PAGES = pages(ROOT / "docs/studies")


@pytest.mark.parametrize("name", PAGES)
def test_stored_tables_give_the_page_to_the_letter_and_nothing_is_run(name, tmp_path, monkeypatch):
    monkeypatch.setattr("railgrip.campaign.evaluate.work", lambda *_, **__: pytest.fail("a stored table lacks cases"))
    committed = PAGES[name].with_suffix(".md").read_text(encoding="utf-8")
    found = execute(PAGES[name], tmp_path).read_text(encoding="utf-8")
    assert found == committed
    figures = re.findall(r"!\[.+\]\((.+\.svg)\)", found)
    assert all((PAGES[name].parent / file).is_file() for file in figures)
    # Those in other folders belong to other pages.
    assert all((tmp_path / file).is_file() for file in figures if "/" not in file)


PAGE = """# %% [markdown]
# # Title
#
# Text.

# %% tags=["parameters"]
quick = False

# %%
import numbers_of_page

import railgrip as rg

print("quick" if quick else "whole")
rg.evaluate(numbers_of_page.square, [{"number": number} for number in (2, 3)], "mine.csv")
frame = rg.evaluate(numbers_of_page.square, [{"number": number} for number in (2, 3)], "mine.csv")
rg.table(frame, {"square": "{:.1f} m"})
"""


SAVED = """# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---

# %% A title [markdown]
# # Title

# %% [md]
r\"\"\"
The friction $\\mu$ of `x`.
\"\"\"

# %%
1 + 1
"""


def test_a_page_that_a_notebook_has_saved_is_the_same_page(tmp_path):
    """With a header, and text as a string: the forms that Jupytext reads and writes."""
    (tmp_path / "saved.py").write_text(SAVED, encoding="utf-8")
    (tmp_path / "module.py").write_text("ONE = 1\n", encoding="utf-8")
    assert list(pages(tmp_path)) == ["saved"]
    written = execute(tmp_path / "saved.py", tmp_path / "out").read_text(encoding="utf-8")
    assert written.startswith("# Title\n\nThe friction $\\mu$ of `x`.\n\n")
    assert "jupytext" not in written


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.usefixtures("own_cache", "in_process")
def test_a_page_shows_text_output_and_last_value_and_runs_its_cases_once(quick, tmp_path, monkeypatch):
    calls = tmp_path / "calls"
    module = f"def square(number):\n    open({str(calls)!r}, 'a').write('.')\n    return {{'square': number**2 / 3}}\n"
    (tmp_path / "numbers_of_page.py").write_text(module, encoding="utf-8")
    (tmp_path / "mine.py").write_text(PAGE, encoding="utf-8")
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.delitem(sys.modules, "numbers_of_page", raising=False)
    written = execute(tmp_path / "mine.py", tmp_path / "out", quick=quick).read_text(encoding="utf-8")
    form = "quick" if quick else "whole"
    assert written.startswith(f"# Title\n\nText.\n\n{form}\n\n| number | square |\n|--:|--:|\n| 2 | 1.3\u00a0m |")
    assert calls.read_text() == ".."
    stored = (tmp_path / ("out" if quick else "") / "mine.csv").read_text(encoding="utf-8")
    assert stored.startswith(f"number,square\n2,{4 / 3!r}\n")


@pytest.mark.usefixtures("own_cache", "in_process")
def test_stored_tables_are_replaced_only_when_all_cases_have_run(tmp_path, monkeypatch):
    studies = tmp_path / "docs/studies"
    studies.mkdir(parents=True)
    module = studies / "numbers_of_page.py"
    (studies / "mine.py").write_text(PAGE, encoding="utf-8")
    (studies / "mine.csv").write_text("stored", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    for body, stored in (("1 / 0", "stored"), ("{'square': number**2}", "number,square\n2,4\n3,9\n")):
        monkeypatch.delitem(sys.modules, "numbers_of_page", raising=False)
        module.write_text(f"def square(number):\n    return {body}\n", encoding="utf-8")
        with nullcontext() if stored != "stored" else pytest.raises(ZeroDivisionError):
            assert exit_code("tools", "pages", "mine", "--anew") == 0
        assert (studies / "mine.csv").read_text(encoding="utf-8") == stored
    assert exit_code("tools", "pages", "mine", "--quick") == 0
    assert (studies / "mine.csv").read_text(encoding="utf-8") == stored
