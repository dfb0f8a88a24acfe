const buttons = ["toImage", "zoom2d", "pan2d", "resetScale2d"];  // of plotly's, those that send nothing anywhere
const config = {responsive: true, displaylogo: false, displayModeBar: "hover", modeBarButtons: [buttons]};
const darkColours = {  // what is drawn for a light page -> the same for a dark one
  "#0f172a": "#f8fafc", "#334155": "#cbd5e1", "#e2e8f0": "#334155", "#cbd5e1": "#475569", "#94a3b8": "#64748b",
  "#ffffff": "#1e293b", "#2563eb": "#60a5fa", "#dc2626": "#f87171", "#059669": "#34d399", "#9333ea": "#c084fc",
  "#bfdbfe": "#1e40af", "#a7f3d0": "#065f46",
  "#be185d": "#f472b6", "#4d7c0f": "#a3e635", "#15803d": "#4ade80", "#7c3aed": "#a78bfa", "#475569": "#94a3b8",
};
const scheme = window.matchMedia("(prefers-color-scheme: dark)");
function coloured(value) {
  if (typeof value === "string") return scheme.matches ? darkColours[value.toLowerCase()] ?? value : value;
  if (Array.isArray(value)) return typeof value[0] === "number" ? value : value.map(coloured);
  if (value === null || typeof value !== "object") return value;
  return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, coloured(inner)]));
}
function draw() {
  for (const [id, data, layout] of plots) Plotly.react(id, coloured(data), coloured(layout), config);
}
const legendLine = 20;  // pixels of a legend of one line, for which every plot has room
function makeRoom() {  // in a narrow window a legend has more lines, and the plot below it is to stay as high
  for (const [id] of plots) {
    const place = document.getElementById(id), legend = place.querySelector(".legend .scrollbox");
    if (!legend) continue;
    place.style.height = place.dataset.height ??= place.style.height;  // without what was added for another width
    const more = Math.round(legend.getBBox().height) - legendLine;
    if (more > 0) place.style.height = `${place.clientHeight + more}px`;
    Plotly.Plots.resize(place);
  }
}
const timed = plots.filter((plot) => plot[3]).map((plot) => plot[0]);
let moving = false;
draw();
makeRoom();
window.addEventListener("resize", makeRoom);
scheme.addEventListener("change", draw);
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
// Paper has another width than the window: plots are drawn anew for it, lower, three to a page.
const paper = {width: 660, share: 0.8, mostHigh: 480};
function drawForPaper() {
  for (const [id] of plots) {
    const {dataset, style, clientHeight} = document.getElementById(id);
    const height = (dataset.height ?? style.height) ? clientHeight : Math.min(paper.share * clientHeight, paper.mostHigh);
    const size = {autosize: false, width: paper.width, height};
    Plotly.relayout(id, size);
    Plotly.relayout(id, size);  // once more: the first one leaves room for the legend of the old width
  }
}
function drawForWindow() {
  for (const [id] of plots) Plotly.relayout(id, {autosize: true, width: null, height: null});
}
window.addEventListener("beforeprint", drawForPaper);
window.addEventListener("afterprint", drawForWindow);
