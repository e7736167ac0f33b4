"""The contents of a page."""

import base64
import gzip
import json
import re

import numpy as np


def figures_of(page):
    """Return the figures of a page, by their texts for readers who do not see them, as SVG."""
    found = re.findall(
        r'<img class="broad" alt="(.*?)"[^>]*src="data:image/svg\+xml;base64,(.*?)">', page.read_text(encoding="utf-8")
    )
    return {name: base64.b64decode(content).decode() for name, content in found}


def signals_of(page):
    """Return the figure of the signals of a stop, as data and layout of plotly.js."""
    packed = re.search(r'id="signals">([^<]*)<', page.read_text(encoding="utf-8")).group(1)
    return json.loads(gzip.decompress(base64.b64decode(packed)))


def replace_signals(page, plot):
    """Replace the figure of the signals of a stop."""
    packed = base64.b64encode(gzip.compress(json.dumps(plot).encode())).decode()
    text = page.read_text(encoding="utf-8")
    page.write_text(re.sub(r'(?<=id="signals">)[^<]*', packed, text), encoding="utf-8")


def numbers(packed):
    """Return the numbers of an array of a figure."""
    return np.frombuffer(base64.b64decode(packed["bdata"]), dtype=packed["dtype"])


def needs_nothing_else(page):
    """Return whether a page loads nothing from elsewhere; links to other pages are allowed."""
    text = page.read_text(encoding="utf-8")
    loaded = re.findall(r"<(?:script|img|link|iframe)[^>]*(?:src|href)=(?!.data:)|@import|url\(|fetch\(|https?:", text)
    return not loaded and page.stat().st_size < 5e6
