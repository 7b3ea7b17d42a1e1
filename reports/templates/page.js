"use strict";
// Every chart is one of the page's specifications, filled with its own scene's curves.
async function draw(figure) {
  const specification = JSON.parse(document.getElementById(figure.dataset.specification).textContent);
  const { datasets, signals } = JSON.parse(figure.querySelector("script").textContent);
  const params = specification.params.map((param) => ({ ...param, value: signals[param.name] ?? param.value }));
  const { view } = await vegaEmbed(
    figure.querySelector(".canvas"),
    { ...specification, params, datasets },
    {
      renderer: "svg",
      actions: { export: true, source: false, compiled: false, editor: false },
      tooltip: { theme: matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light" },
    },
  );

  const boxes = [...figure.querySelectorAll(".legend input")];
  for (const box of boxes) {
    const pick = (name) => () => view.signal("picked", name).run();
    box.addEventListener("change", () => {
      view.signal("hidden", boxes.filter((each) => !each.checked).map((each) => each.value)).run();
    });
    box.parentElement.addEventListener("pointerenter", pick(box.value));
    box.parentElement.addEventListener("pointerleave", pick(""));
    box.addEventListener("focus", pick(box.value));
    box.addEventListener("blur", pick(""));
  }
}

document.querySelectorAll("figure.chart").forEach(draw);
