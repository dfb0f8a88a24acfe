"""The page of a report: everything in one file, so that it opens without a network, today and in ten years."""

from __future__ import annotations

import string

POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""What the browser may load: nothing that is not in the page."""

PAGE = string.Template("""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="$policy">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<link rel="icon" href="data:,">
<style>
  :root { --ink: #0f172a; --soft: #64748b; --edge: #e2e8f0; --paper: #ffffff; --ground: #f1f5f9; --accent: #2563eb; }
  * { box-sizing: border-box; }
  body { margin: 0; background: var(--ground); color: var(--ink); font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; }
  main { max-width: 1320px; margin: 0 auto; padding: 28px 20px 60px; }
  h1 { font-size: 26px; margin: 0; letter-spacing: -0.02em; }
  h2 { font-size: 16px; margin: 0; }
  p { margin: 0; }
  header { display: flex; flex-wrap: wrap; gap: 6px 16px; align-items: center; margin-bottom: 4px; }
  .verdict { padding: 3px 12px; border-radius: 99px; font-weight: 600; font-size: 14px; }
  .good { background: #dcfce7; color: #166534; }
  .bad { background: #fee2e2; color: #991b1b; }
  .even { background: #e2e8f0; color: #334155; }
  .soft { color: var(--soft); font-size: 13px; overflow-wrap: anywhere; }
  .warning { background: #fef3c7; color: #92400e; padding: 8px 14px; border-radius: 10px; margin-top: 12px; }
  .figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(176px, 1fr)); gap: 10px; margin: 18px 0; }
  .figures div, .card { background: var(--paper); border: 1px solid var(--edge); border-radius: 12px; }
  .figures div { padding: 10px 14px; }
  .figures b { display: block; font-size: 19px; font-variant-numeric: tabular-nums; letter-spacing: -0.01em; }
  .plots { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 12px; }
  .card { padding: 14px 16px 8px; min-width: 0; }
  .wide { grid-column: 1 / -1; }
  .section { grid-column: 1 / -1; font-size: 20px; margin: 16px 0 0; }
  .plot { height: 300px; }
  .wide .plot { height: 520px; }
  .key { display: flex; flex-wrap: wrap; gap: 4px 16px; margin: 0 0 12px; }
  .key i { display: inline-block; width: 12px; height: 12px; border-radius: 3px; margin-right: 6px; opacity: 0.45; }
  table { border-collapse: collapse; width: 100%; margin: 8px 0; font-size: 14px; }
  td { padding: 4px 10px 4px 0; border-top: 1px solid var(--edge); vertical-align: top; overflow-wrap: anywhere; }
  td:first-child { white-space: nowrap; color: var(--soft); font-variant-numeric: tabular-nums; width: 1%; }
  @media (max-width: 800px) { .plots { grid-template-columns: minmax(0, 1fr); } }
  @media print { body { background: none; } .card { break-inside: avoid; } }
</style>
</head>
<body>
<main>
<header><h1>$title</h1><span class="verdict $mood">$verdict</span></header>
<p>$description</p>
<p class="soft">$identity</p>
$warning
<section class="figures">$figures</section>
<p class="key soft">$key</p>
<section class="plots">$cards
<div class="card"><h2>Events</h2><table>$events</table></div>
<div class="card"><h2>Made by</h2><table>$origin</table></div>
</section>
<p class="soft" style="margin-top:14px">$thinned Drag to zoom, double-click to see all; the time axes move together.</p>
</main>
<script>$plotly</script>
<script>
const plots = $plots;
const buttons = ["toImage", "zoom2d", "pan2d", "resetScale2d"];  // of plotly's, those that send nothing anywhere
const config = {responsive: true, displaylogo: false, displayModeBar: "hover", modeBarButtons: [buttons]};
const timed = [];
let moving = false;
for (const [id, data, layout, overTime] of plots) {
  Plotly.newPlot(id, data, layout, config);
  if (overTime) timed.push(id);
}
for (const id of timed) {
  const moved = document.getElementById(id);
  moved.on("plotly_relayout", (change) => {
    if (moving || !Object.keys(change).some((key) => key.startsWith("xaxis."))) return;
    moving = true;
    const update = () => ({"xaxis.range": [...moved.layout.xaxis.range]});
    Promise.all(timed.filter((other) => other !== id).map((other) => Plotly.relayout(other, update())))
      .finally(() => { moving = false; });
  });
}
</script>
</body>
</html>
""")
