"""What a browser draws of a page: texts that overlap, low axes, and legends over lines and bars."""

import json
import re
import shutil
import subprocess
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
WIDTHS = (1280, 800, 390)
"""Widths of a screen, a half one and a telephone [pixels]."""

LOWEST = 150  # pixels
_SMALLEST = 0.75
"""Size of a figure over its size on paper, with letters of 8 points, so that they have 8 pixels."""

_TOUCH = 2.0
"""Overlap of the boxes of two texts that is not one of their letters: boxes are higher than letters [pixels]."""

_SCRIPT = """<script>
addEventListener("load", async () => {
  while (document.querySelector(".plot") && document.body.dataset.drawn !== "yes")
    await new Promise((done) => setTimeout(done, 50));
  const box = (one) => {
    const { left, right, top, bottom } = one.getBoundingClientRect();
    return { left, right, top, bottom };
  };
  const plots = [...document.querySelectorAll(".plot")].filter((one) => one._fullLayout).map((plot) => {
    const axes = Object.values(plot._fullLayout).filter((one) => one && one._id && one._length && !one.overlaying);
    const lines = [...plot.querySelectorAll(".scatterlayer path.js-line, .barlayer path")].flatMap((path) => {
      const shift = path.getScreenCTM(), length = path.getTotalLength();
      return Array.from({ length: 300 }, (_, k) => {
        const { x, y } = path.getPointAtLength((k / 299) * length).matrixTransform(shift);
        return [x, y];
      });
    });
    const texts = [...plot.querySelectorAll("svg.main-svg text")].filter(
      (one) => one.textContent.trim() && one.getBBox().width);
    return {
      frame: box(plot.querySelector(".svg-container")),
      heights: axes.filter((one) => one._id[0] === "y").map((one) => one._length),
      texts: texts.map((one) => ({ ...box(one), text: one.textContent })),
      legends: [...plot.querySelectorAll(".legend .bg")].map(box), lines,
    };
  });
  const figures = [...document.querySelectorAll(".figure img")].filter((one) => one.offsetWidth).map((one) => (
    { ...box(one), name: one.alt, shown: box(one.parentElement), scale: one.offsetWidth / one.naturalWidth }));
  parent.document.title = JSON.stringify({ width: innerWidth, plots, figures });
});
</script>"""


def command_for(page, folder, *options):
    """Return the command that opens a page in a browser; the folder is for its profile."""
    return [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars",
            "--disable-background-networking", "--allow-file-access-from-files",
            f"--user-data-dir={folder / 'profile'}", *options, page.resolve().as_uri()]  # fmt: skip


def browse(page, folder, *options):
    """Return the output of a browser for a page; the folder is for its profile."""
    command = command_for(page, folder, "--virtual-time-budget=20000", *options)
    return subprocess.run(command, check=True, capture_output=True, timeout=300, encoding="utf-8").stdout


def title_of(page, folder, *options):
    """Return the title of a page after its scripts have run."""
    return re.search(r"<title>(.*?)</title>", browse(page, folder, "--dump-dom", *options), re.DOTALL).group(1)


_FORWARD = """<iframe src="posting.html" style="width:100%;height:900px"></iframe><script>
addEventListener("message", ({{ data: body }}) =>
  fetch("http://127.0.0.1:{port}", {{ method: "POST", mode: "no-cors", body }}));
</script>"""


def posted_by(text, folder):
    """Return the text that a page posts to its parent, in real time, which workers need."""
    (folder / "posting.html").write_text(text, encoding="utf-8")
    bodies = []

    class Receiver(BaseHTTPRequestHandler):
        def do_POST(self):
            bodies.append(self.rfile.read(int(self.headers["Content-Length"])).decode())
            self.send_response(204)
            self.end_headers()

        def log_message(self, *args):
            pass

    with HTTPServer(("127.0.0.1", 0), Receiver) as server:
        server.timeout = 600.0
        (folder / "outer.html").write_text(_FORWARD.format(port=server.server_port), encoding="utf-8")
        browser = subprocess.Popen(command_for(folder / "outer.html", folder), stderr=subprocess.DEVNULL)
        try:
            server.handle_request()
        finally:
            browser.terminate()
            browser.wait()
    return bodies[0]


_COLLECT = """<script>
addEventListener("load", async () => {
  const titles = () => [...document.querySelectorAll("iframe")].map((one) => one.contentDocument.title);
  while (!titles().every(Boolean)) await new Promise((done) => setTimeout(done, 50));
  document.title = `[${titles().join()}]`;
});
</script>"""


def drawn(frames, folder):
    """Return the places of texts and axes that a browser draws of pages in frames, in one run.

    A window is never narrower than 500 pixels.

    Args:
        frames: Page and width of each frame [pixels], which is 900 pixels high.
        folder: Folder for the profile of the browser.
    """
    folder.mkdir(exist_ok=True)
    for number, (page, width) in enumerate(frames):
        text = page.read_text(encoding="utf-8").replace("</body>", f"{_SCRIPT}</body>")
        (folder / f"measured{number}.html").write_text(text, encoding="utf-8")
        frame = f'<iframe src="measured{number}.html" style="width:{width}px;height:900px;border:0"></iframe>'
        (folder / f"frame{number}.html").write_text(frame, encoding="utf-8")
    outer, count = folder / "outer.html", len(frames)
    one = '<iframe src="frame{}.html" style="width:1400px;height:950px;border:0;display:block"></iframe>'
    outer.write_text("".join(map(one.format, range(count))) + _COLLECT, encoding="utf-8")
    options = (f"--window-size=1400,{1000 * count}", f"--virtual-time-budget={20_000 * count}")
    found = json.loads(title_of(outer, folder, *options))
    assert [each["width"] for each in found] == [width for _, width in frames]
    return found


def defects_of(found):
    """Return a sentence for each defect of the figures of a page as `drawn` returns it."""
    defects = []
    for one in found["figures"]:
        if one["shown"]["right"] > found["width"]:
            defects.append(f"{one['name']}: it does not scroll, and is cut off")
        if one["scale"] < _SMALLEST:
            defects.append(f"{one['name']}: it is {100 * one['scale']:.0f} % as large as on paper")
    for plot in found["plots"]:
        texts, frame = plot["texts"], plot["frame"]
        defects += [f"an axis is {round(size)} pixels high" for size in plot["heights"] if size < LOWEST]
        for number, text in enumerate(texts):
            if text["left"] < frame["left"] - 1 or text["right"] > frame["right"] + 1:
                defects.append(f"'{text['text']}' is cut off")
            if text["top"] < frame["top"] - 1 or text["bottom"] > frame["bottom"] + 1:
                defects.append(f"'{text['text']}' is cut off")
            defects += [
                f"'{text['text']}' overlaps '{other['text']}'"
                for other in texts[number + 1 :]
                if _overlap(text, other) > _TOUCH
            ]
        for legend in plot["legends"]:
            inside = [(x, y) for x, y in plot["lines"] if _has(legend, x, y)]
            if inside:
                defects.append(f"a legend covers {len(inside)} points of lines or bars")
    return defects


def _overlap(first, second):
    width = min(first["right"], second["right"]) - max(first["left"], second["left"])
    height = min(first["bottom"], second["bottom"]) - max(first["top"], second["top"])
    return min(width, height)


def _has(box, x, y):
    return box["left"] + 1 < x < box["right"] - 1 and box["top"] + 1 < y < box["bottom"] - 1
