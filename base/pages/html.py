"""Pages of one HTML file with everything inside: no script, and no reference to anything else."""

import base64
from collections.abc import Iterable, Sequence
from html import escape

from navtool.base.pages.style import page_style

_STYLE = """
body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--ground);max-width:1080px;margin:2rem auto;
padding:0 1rem}h1{font-size:1.4rem;overflow-wrap:anywhere}h2{font-size:1.1rem;margin:2rem 0 .6rem}
table{border-collapse:collapse;width:100%;font-size:.9rem}td,th{padding:.25rem .6rem;border-bottom:1px solid
var(--line);text-align:left;vertical-align:top}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}
.wide{overflow-x:auto}.dim{color:var(--dim)}.bad{color:var(--bad)}.row{display:flex;flex-wrap:wrap;gap:1rem}
figure{margin:0}figcaption{font-size:.85rem;color:var(--dim)}img{max-width:100%;border-radius:4px}
code{overflow-wrap:anywhere}
"""


def html_page(title: str, parts: Iterable[str]) -> str:
    """A page of parts that are HTML already; the title is a text and gets escaped."""
    head = (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width,initial-scale=1">',
        f"<title>{escape(title)}</title><style>{page_style()}{_STYLE}</style></head><body>",
        f"<h1>{escape(title)}</h1>",
    )
    return "\n".join([*head, *parts, "</body></html>\n"])


def html_figure(content: bytes, kind: str, caption: str) -> str:
    """A picture with its caption.

    Args:
        content: Bytes of the file.
        kind: ``png`` or ``jpeg``.
        caption: A text.
    """
    source = f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
    return f'<figure><img src="{source}" alt="{escape(caption)}"><figcaption>{escape(caption)}</figcaption></figure>'


def html_table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table of texts and numbers; numbers stand to the right, None is left empty."""
    head = "".join(f"<th>{escape(column)}</th>" for column in columns)
    body = "".join(f"<tr>{''.join(_cell(value) for value in row)}</tr>" for row in rows)
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f'<td class="n">{value:.3g}</td>'
    if isinstance(value, int):
        return f'<td class="n">{value}</td>'
    return f"<td>{'' if value is None else escape(str(value))}</td>"
