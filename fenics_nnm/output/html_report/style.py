"""The look of the page: one column on a telephone, contents beside it on a desktop."""

from __future__ import annotations

STYLE = """
:root {
  --ink: #1c2430; --soft: #566173; --line: #d7dce3; --paper: #fff; --raised: #f5f7fa;
  --accent: #00558c; --warn: #8a4b00; --warn-paper: #fff6e8;
  --shade: #1c243040;
}
@media (prefers-color-scheme: dark) {
  :root {
    --ink: #e4e8ee; --soft: #a3adbb; --line: #3a4351; --paper: #14181f; --raised: #1d232c;
    --accent: #7cc0f0; --warn: #f2bd6a; --warn-paper: #2c2416;
    --shade: #e4e8ee40;
  }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; scroll-padding-top: 1rem; }
body {
  margin: 0 auto; padding: 1.25rem 1rem 3rem; max-width: 52rem;
  color: var(--ink); background: var(--paper);
  font: 1rem/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans",
    sans-serif;
  overflow-wrap: anywhere;
}
a { color: var(--accent); }
h1 { margin: 0; font-size: clamp(1.5rem, 1.2rem + 1.6vw, 2.2rem); line-height: 1.2; }
h2 { margin: 0 0 .8rem; font-size: 1.3rem; line-height: 1.3; }
h3 { margin: 1.6rem 0 .5rem; font-size: 1.05rem; }
p { margin: 0 0 .9rem; max-width: 44rem; }
.kicker { margin: 0 0 .3rem; color: var(--soft); font-size: .9rem; }
.note, figcaption, footer { color: var(--soft); font-size: .9rem; }
nav { margin: 1.25rem 0 0; padding: .8rem 1rem; background: var(--raised); border-radius: .5rem; }
nav h2 { margin: 0 0 .3rem; font-size: .9rem; color: var(--soft); }
nav ol { margin: 0; padding-left: 1.4rem; columns: 9rem; font-size: .95rem; }
nav li { padding: .12rem 0; break-inside: avoid; }
section { margin-top: 2.2rem; padding-top: 1.6rem; border-top: 1px solid var(--line); }
.facts {
  display: grid; grid-template-columns: repeat(auto-fit, minmax(9.5rem, 1fr));
  gap: .6rem; margin: 0 0 1.2rem;
}
.facts div { padding: .6rem .8rem; background: var(--raised); border-radius: .5rem; }
.facts dt { color: var(--soft); font-size: .82rem; line-height: 1.3; }
.facts dd { margin: .15rem 0 0; font-size: 1.15rem; font-weight: 600; }
.warnings {
  margin: 0 0 1.2rem; padding: .8rem 1rem; color: var(--ink); background: var(--warn-paper);
  border-left: .25rem solid var(--warn); border-radius: 0 .5rem .5rem 0;
}
.warnings h3 { margin: 0 0 .3rem; color: var(--warn); }
.warnings ul { margin: 0; }
ul { padding-left: 1.2rem; }
li + li { margin-top: .3rem; }
.scroll {
  overflow-x: auto; width: fit-content; max-width: 100%; margin: 0 0 1rem;
  border: 1px solid var(--line); border-radius: .5rem;
  background: /* a shade at the side where there is more */
    linear-gradient(to right, var(--paper) 40%, transparent) left / 3rem 100% no-repeat local,
    linear-gradient(to left, var(--paper) 40%, transparent) right / 3rem 100% no-repeat local,
    linear-gradient(to right, var(--shade), transparent) left / .9rem 100% no-repeat scroll,
    linear-gradient(to left, var(--shade), transparent) right / .9rem 100% no-repeat scroll;
}
.scroll:focus-visible { outline: 2px solid var(--accent); }
table { border-collapse: collapse; font-size: .9rem; line-height: 1.35;
  font-variant-numeric: tabular-nums; }
th, td { padding: .4rem .7rem; text-align: left; vertical-align: top; overflow-wrap: normal; }
th { color: var(--soft); font-weight: 600; vertical-align: bottom;
  border-bottom: 2px solid var(--line); }
tr + tr td { border-top: 1px solid var(--line); }
.number { text-align: right; }
td.number, .word { white-space: nowrap; }
td.prose { min-width: 15rem; max-width: 34rem; }
.figures {
  columns: 22rem 2; column-gap: 1.4rem; margin: 0 0 .4rem;
}
figure { margin: 0; padding-bottom: 1.4rem; break-inside: avoid; }
figure.wide { column-span: all; }
figure.live { max-width: 40rem; }
figure.live svg {
  display: block; width: 100%; height: auto; background: var(--paper);
  border: 1px solid var(--line); border-radius: .5rem; font-size: 12px;
}
.live text { fill: var(--ink); }
.live .grid { stroke: var(--line); stroke-width: .6; }
.live .linear { stroke: var(--soft); stroke-dasharray: 2 3; }
.live .order { stroke: var(--warn); stroke-dasharray: 6 3; }
.live .curve { stroke: var(--accent); stroke-width: 1.6; }
.live .verified { fill: var(--accent); stroke: var(--paper); }
.live .converged { fill: var(--paper); stroke: var(--accent); stroke-width: 1.6; }
.live .inside { fill: var(--paper); stroke: #cc79a7; stroke-width: 1.6; }
.live .failed { fill: none; stroke: #d55e00; stroke-width: 2; }
.live circle:hover, .live rect:hover, .live path:hover { stroke-width: 4; }
.stage {
  position: relative; overflow: hidden; height: min(26rem, 70vw); background: #fff;
  border: 1px solid var(--line); border-radius: .5rem;
}
.stage:focus-visible { outline: 2px solid var(--accent); }
.controls { display: flex; flex-wrap: wrap; gap: .5rem 1rem; margin: .6rem 0 .4rem; }
.controls label {
  display: flex; flex: 1 1 15rem; gap: .5rem; align-items: center; font-size: .9rem;
}
.controls input { flex: 1; min-width: 5rem; accent-color: var(--accent); }
.controls output { min-width: 4.5rem; font-variant-numeric: tabular-nums; }
.controls button {
  padding: .35rem .9rem; min-width: 5rem; font: inherit; color: var(--ink);
  background: var(--raised); border: 1px solid var(--line); border-radius: .4rem; cursor: pointer;
}
.scale { display: flex; gap: .5rem; align-items: center; font-size: .85rem; color: var(--soft); }
.scale .bar { flex: 0 1 10rem; height: .7rem; border: 1px solid var(--line); }
figure img {
  display: block; width: 100%; height: auto;
  padding: .4rem; background: #fff; border: 1px solid var(--line); border-radius: .5rem;
}
figcaption { margin-top: .5rem; }
figcaption strong { color: var(--ink); }
details { margin: 0 0 1rem; }
summary { cursor: pointer; color: var(--accent); padding: .2rem 0; }
details > .scroll { margin-top: .5rem; }
pre {
  margin: 0; padding: .9rem 1rem; overflow-x: auto; background: var(--raised);
  border: 1px solid var(--line); border-radius: .5rem;
  font: .85rem/1.5 ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace;
}
footer { margin-top: 2.5rem; padding-top: 1rem; border-top: 1px solid var(--line); }
@media (max-width: 34rem) { /* tables of rows and columns become lists */
  .scroll { width: auto; background: none; }
  thead { display: none; }
  tbody tr {
    display: grid; grid-template-columns: 1fr 1fr; gap: .1rem .8rem; padding: .5rem .7rem;
  }
  tr + tr { border-top: 1px solid var(--line); }
  tr + tr td { border-top: 0; }
  td, td.number, td.prose, .word {
    padding: 0; min-width: 0; text-align: left; white-space: normal;
  }
  td:empty { display: none; }
  td::before { content: attr(data-heading); display: block; color: var(--soft); font-size: .8rem; }
}
@media (min-width: 70rem) {
  body {
    display: grid; grid-template-columns: 15rem minmax(0, 52rem); column-gap: 3rem;
    max-width: 72rem; padding-top: 2.5rem;
  }
  header, footer { grid-column: 1 / -1; }
  nav { position: sticky; top: 1rem; align-self: start; margin-top: 1.6rem; }
  nav ol { columns: auto; }
  main > section:first-child { border-top: 0; margin-top: 0; }
}
@media print {
  :root {
    --ink: #000; --soft: #444; --line: #bbb; --paper: #fff; --raised: #fff; --accent: #000;
    --warn: #000; --warn-paper: #fff;
  }
  body { display: block; max-width: none; padding: 0; font-size: 10pt; }
  nav, .turning { display: none; }
  .figures { columns: 2; }
  figure, tr, .facts, .warnings { break-inside: avoid; }
  h2, h3 { break-after: avoid; }
  .scroll, pre { overflow: visible; border: 0; background: none; }
  table { font-size: 7.5pt; }
  th, td { padding: 2pt 4pt; }
  td.prose { min-width: 0; }
  pre { white-space: pre-wrap; }
  details::details-content { content-visibility: visible; display: block; }
}
"""
