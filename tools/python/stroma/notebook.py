# SPDX-License-Identifier: LGPL-2.1-or-later
"""The live view below the cell of Jupyter that runs: in a frame where the notebook is of this machine and comes by http, else as a
link. A browser keeps what comes by http, as the view, out of pages that come by https."""
import html
import json
import os
import sys
from typing import List, Sequence

_HEIGHT = 560  # [pixels]


def _in_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")


def _server() -> dict:
    """What the server of notebooks that has started this kernel has written about itself, or nothing."""
    try:
        from jupyter_core.paths import jupyter_runtime_dir
    except ImportError:
        return {}
    number = os.environ.get("JPY_PARENT_PID", "")
    for name in (f"jpserver-{number}.json", f"nbserver-{number}.json"):
        try:
            with open(os.path.join(jupyter_runtime_dir(), name), encoding="utf-8") as stream:
                return json.load(stream)
        except (OSError, ValueError):
            pass
    return {}


def origins(host: str) -> List[str]:
    """Of the notebook's pages, where they and a view at `host` are of this machine and a browser lets one reach the other: by
    http, at the loopback."""
    if not _in_notebook() or host not in ("127.0.0.1", "localhost"):
        return []
    server = _server()
    port = server.get("port")
    if server.get("secure") or not isinstance(port, int) or not 0 < port < 65536:
        return []
    return [f"http://{name}" + (f":{port}" if port != 80 else "") for name in ("localhost", "127.0.0.1")]


# The frame has the name that the notebook was opened by: a browser keeps the cookie of another name from it.
_FRAME = """<div id="{name}"></div><script>
(() => {{
  const address = new URL({address});
  if (!{origins}.includes(location.origin)) return;
  address.hostname = location.hostname;
  const frame = document.createElement("iframe");
  frame.src = address.href;
  frame.width = "100%", frame.height = {height}, frame.style.border = "0", frame.allow = "fullscreen";
  document.getElementById({quoted}).append(frame);
}})()
</script>"""


_NO_FRAME = """. A browser shows it inside of notebooks of this machine that come by http;
<code>simulation.page("run.html")</code> plays a run inside of any notebook, by https and from other machines too"""


def show(address: str, allowed: Sequence[str]) -> bool:
    """Below the cell. A browser on another machine than this program's has the link alone. True where there is a frame."""
    if not _in_notebook():
        return False
    from IPython.display import HTML, display
    text = f'<a href="{html.escape(address)}" target="_blank">The live view</a>, until the kernel is interrupted'
    if allowed:
        name = "stroma_" + address.split("/")[2].split(":")[-1]
        text += _FRAME.format(name=name, quoted=json.dumps(name), address=json.dumps(address), origins=json.dumps(list(allowed)),
                              height=_HEIGHT)
    else:
        text += _NO_FRAME
    display(HTML(text))
    return bool(allowed)
