"use strict";
// Every chart is the one specification, filled with its own scene's curves.
const specification = JSON.parse(document.getElementById("specification").textContent);

async function draw(figure) {
  const { curves, limit, bottom, top } = JSON.parse(figure.querySelector("script").textContent);
  const { view } = await vegaEmbed(
    figure.querySelector(".canvas"),
    { ...specification, datasets: { curves, limit } },
    {
      renderer: "svg",
      actions: { export: true, source: false, compiled: false, editor: false },
      tooltip: { theme: matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light" },
    },
  );
  await view.signal("bottom", bottom).signal("top", top).runAsync();

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
