// Draws every figure of the page and keeps their text readable when the reader's colour scheme changes.
(() => {
  "use strict";
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const ink = () => (dark.matches ? "#e7eaf0" : "#1c2330");
  const config = {
    responsive: true,
    displaylogo: false,
    showSendToCloud: false,
    modeBarButtonsToRemove: ["select2d", "lasso2d"],
  };
  const holders = [...document.querySelectorAll(".figure")];

  for (const holder of holders) {
    const figure = JSON.parse(document.getElementById(holder.dataset.source).textContent);
    figure.layout.font = { ...figure.layout.font, color: ink() };
    Plotly.newPlot(holder, figure.data, figure.layout, config).then(() => {
      if (figure.frames && figure.frames.length) return Plotly.addFrames(holder, figure.frames);
    });
  }
  dark.addEventListener("change", () => {
    for (const holder of holders) Plotly.relayout(holder, { "font.color": ink() });
  });
})();
