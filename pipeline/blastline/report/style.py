"""The colours of page and figures, the figures' settings and the page's style sheet.

The colours in figures are written as the distinct values below and replaced by variables of the style sheet. They keep
apart for the common forms of colour blindness (Okabe and Ito 2008), and every one is also told by its place or label.
"""

SERIES = {
    "audio": "#a7b4c6",
    "band": "#5c6b80",
    "direct": "#d7862b",
    "drive": "#8a63b8",
    "felt": "#0f8f72",
    "limit": "#c8463c",
    "blast": "#e3b233",
    "reflection": "#4aa0d8",
    "window": "#b9c3d0",
}

INK = {"strong": "#1b2430", "soft": "#5a6778", "faint": "#aab4c1", "grid": "#e4e8ee"}

_DARK_SERIES = {
    "audio": "#4d5a6d",
    "band": "#a9b6c8",
    "direct": "#eb9f4a",
    "drive": "#b48fe0",
    "felt": "#35c29f",
    "limit": "#ee7468",
    "blast": "#e8bf4f",
    "reflection": "#62b5ea",
    "window": "#3c485a",
}

_DARK_INK = {"strong": "#e8edf3", "soft": "#9fabbb", "faint": "#566274", "grid": "#2a3442"}


def figure_settings(salt: str) -> dict[str, object]:
    """Return matplotlib's settings for every figure: quiet axes, text that stays text, the same file for one salt."""
    return {
        "svg.fonttype": "none",
        "svg.hashsalt": salt,
        "font.family": "sans-serif",
        "axes.edgecolor": INK["faint"],
        "axes.labelcolor": INK["soft"],
        "axes.linewidth": 0.6,
        "xtick.color": INK["soft"],
        "ytick.color": INK["soft"],
        "text.color": INK["strong"],
        "axes.spines.top": False,
        "axes.spines.right": False,
        "xtick.major.size": 2.5,
        "ytick.major.size": 2.5,
    }


def _variables(series: dict[str, str], ink: dict[str, str]) -> str:
    pairs = [*series.items(), *((f"ink-{name}", colour) for name, colour in ink.items())]
    return "".join(f"--{name}:{colour};" for name, colour in pairs)


_LIGHT = (
    f":root{{color-scheme:light dark;{_variables(SERIES, INK)}"
    "--page:#f5f7f9;--card:#fff;--line:#dfe4ea;--good:#0c7a5c;--good-tint:#e4f4ee;--bad:#b3261e;--bad-tint:#fbe9e7;"
    "--warn:#8a5a00;--warn-tint:#fdf3dc;--link:#1f5fae}"
)
_DARK = (
    f"@media screen and (prefers-color-scheme:dark){{:root{{{_variables(_DARK_SERIES, _DARK_INK)}"
    "--page:#10161e;--card:#18202b;--line:#2a3442;--good:#4cc9a4;--good-tint:#12312a;--bad:#ff8a80;--bad-tint:#3a1d1b;"
    "--warn:#f0c15b;--warn-tint:#352a12;--link:#7db4f5}}"
)

STYLE = (
    _LIGHT
    + _DARK
    + """
*{box-sizing:border-box}
html{scroll-behavior:smooth}
body{margin:0;background:var(--page);color:var(--ink-strong);
font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif;font-variant-numeric:tabular-nums;
overflow-wrap:anywhere}
main,header,footer{max-width:1180px;margin:0 auto;padding:0 28px}
a{color:var(--link);text-underline-offset:2px}
a:focus-visible,button:focus-visible,input:focus-visible,summary:focus-visible{outline:2px solid var(--link);
outline-offset:2px;border-radius:3px}
header{padding-top:34px}
.product{margin:0;color:var(--ink-soft);font-size:13px;letter-spacing:.04em}
h1{margin:2px 0 4px;font-size:30px;line-height:1.2;font-weight:650;letter-spacing:-.01em}
.facts{margin:0;color:var(--ink-soft)}
h2{margin:44px 0 6px;font-size:19px;font-weight:650}
h2+p,.note{margin:0 0 14px;color:var(--ink-soft);max-width:78ch}
nav{margin-top:18px;display:flex;gap:18px;flex-wrap:wrap;font-size:14px}
.verdict{margin:22px 0 0;padding:16px 20px;border-radius:10px;font-size:17px;border:1px solid transparent}
.verdict strong{font-weight:650}
.verdict ul{margin:8px 0 0;padding-left:20px;font-size:15px}
.good{background:var(--good-tint);color:var(--good);border-color:color-mix(in srgb,var(--good) 25%,transparent)}
.bad{background:var(--bad-tint);color:var(--bad);border-color:color-mix(in srgb,var(--bad) 25%,transparent)}
.warn{background:var(--warn-tint);color:var(--warn);border-color:color-mix(in srgb,var(--warn) 25%,transparent)}
.verdict span,.verdict li{color:var(--ink-strong)}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(160px,1fr));gap:12px;margin:18px 0 0}
.tile{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:12px 16px}
.tile dt{color:var(--ink-soft);font-size:13px}
.tile dd{margin:0;font-size:21px;font-weight:600;line-height:1.3}
.tile dd small{display:block;font-size:13px;font-weight:400;color:var(--ink-soft);line-height:1.35}
.tile .name{font-size:16px}
.card{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:16px 20px;margin:0 0 18px}
.scroll{overflow-x:auto}
svg{display:block;width:100%;height:auto}
.scroll svg{min-width:800px}
svg text{font-family:inherit!important}
.legend{display:flex;flex-wrap:wrap;gap:6px 18px;margin:0 0 10px;padding:0;list-style:none;font-size:13px;
color:var(--ink-soft)}
.legend i{display:inline-block;width:18px;height:0;border-top:3px solid;margin-right:6px;vertical-align:middle}
.legend i.area{height:11px;border:0;border-radius:2px}
.picture h3{margin:0;font-size:17px;font-weight:650;display:flex;gap:12px;align-items:baseline;flex-wrap:wrap}
.picture h3 span{font-weight:400;font-size:14px;color:var(--ink-soft)}
.picture .badge{margin-left:auto}
.badge{font-size:12.5px;font-weight:600;padding:1px 9px;border-radius:99px;white-space:nowrap}
.numbers{display:grid;grid-template-columns:repeat(auto-fill,minmax(150px,1fr));gap:8px 18px;margin:12px 0 10px}
.numbers dt{color:var(--ink-soft);font-size:12.5px}
.numbers dd{margin:0;font-weight:550}
.why{margin:0 0 10px;color:var(--ink-soft);font-size:13.5px}
table{border-collapse:collapse;width:100%;font-size:13.5px;overflow-wrap:normal}
th,td{padding:6px;text-align:left;border-bottom:1px solid var(--line);white-space:nowrap}
td.wide{white-space:normal}
th{font-weight:600;color:var(--ink-soft);font-size:13px;background:var(--card);white-space:normal;
vertical-align:bottom}
th button{all:unset;cursor:pointer}
th button:hover{text-decoration:underline}
th[aria-sort=ascending] button::after{content:" \\2191";opacity:1}
th[aria-sort=descending] button::after{content:" \\2193";opacity:1}
td.n,th.n{text-align:right}
tbody tr:hover{background:color-mix(in srgb,var(--link) 6%,transparent)}
tr:target,.card:target{outline:2px solid var(--link);outline-offset:-1px}
.ok{color:var(--good)}
.failed{color:var(--bad);font-weight:600}
details{margin:10px 0}
summary{cursor:pointer;padding:4px 0;font-weight:550}
.filter{display:flex;gap:18px;flex-wrap:wrap;align-items:center;margin:0 0 10px;font-size:14px}
.filter[hidden]{display:none}
.filter input[type=search]{font:inherit;padding:5px 10px;border:1px solid var(--line);border-radius:7px;
background:var(--page);color:inherit;min-width:250px}
.origin{display:grid;grid-template-columns:max-content 1fr;gap:4px 18px;margin:0;font-size:14px}
.origin dt{color:var(--ink-soft)}
.origin dd{margin:0}
code{font:13px ui-monospace,Consolas,monospace}
footer{padding-top:30px;padding-bottom:44px;color:var(--ink-soft);font-size:13px}
.track a{text-decoration:none}
.track a:hover line,.track a:hover circle,.track a:focus line,.track a:focus circle{stroke:var(--link);
stroke-width:2.5}
@media (max-width:640px){main,header,footer{padding:0 14px}h1{font-size:24px}}
@media print{
body{background:#fff;font-size:11px}main,header,footer{max-width:none;padding:0}
nav,.filter{display:none}.card,.tile{border-color:#ccc}.picture,.tile,.verdict,tr{break-inside:avoid}
h2{break-after:avoid}th button::after{content:""}.scroll{overflow:visible}
.scroll svg{min-width:0}
}
"""
)
