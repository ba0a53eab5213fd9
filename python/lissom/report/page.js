// Draws the figures of the page when they are first shown, shows what the reader picks, and keeps text readable when
// the reader's colour scheme changes.
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
  const drawn = new Set();

  // On a phone: smaller letters, the slider below the buttons, the legend above and the whole box in sight.
  const NARROW = 600;
  const fit = (layout, width) => {
    if (width >= NARROW) return;
    layout.font.size = 11;
    for (const slider of layout.sliders ?? []) {
      Object.assign(slider, { x: 0, len: 1, pad: { ...slider.pad, t: 60 } });
      layout.margin.b += 50;
    }
    if (layout.scene) {
      layout.scene.domain = { y: [0, 0.8] };
      const { eye } = layout.scene.camera;
      for (const axis of "xyz") eye[axis] *= Math.min(NARROW / width, 1.5);
    }
  };

  const draw = (holder) => {
    if (drawn.has(holder) || holder.closest("[hidden]")) return;
    drawn.add(holder);
    const figure = JSON.parse(document.getElementById(holder.dataset.source).textContent);
    figure.layout.font = { ...figure.layout.font, color: ink() };
    fit(figure.layout, holder.clientWidth);
    Plotly.newPlot(holder, figure.data, figure.layout, config).then(() => {
      if (figure.frames && figure.frames.length) return Plotly.addFrames(holder, figure.frames);
    });
  };

  for (const choice of document.querySelectorAll(".choice")) {
    const select = choice.querySelector("select");
    const options = [...choice.querySelectorAll(".option")];
    select.addEventListener("change", () => {
      options.forEach((option, i) => { option.hidden = i !== select.selectedIndex; });
      for (const holder of options[select.selectedIndex].querySelectorAll(".figure")) {
        draw(holder);
        // The page may have become wider or narrower while the figure was hidden.
        Plotly.Plots.resize(holder);
      }
    });
  }
  holders.forEach(draw);
  dark.addEventListener("change", () => {
    for (const holder of drawn) Plotly.relayout(holder, { "font.color": ink() });
  });
})();
