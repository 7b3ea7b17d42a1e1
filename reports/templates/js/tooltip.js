// The tooltip: what the pointer rests on, in words beside it.

import { make } from "./dom.js";

/** What the pointer rests on, in words beside it. */
export const tooltip = make("div", { id: "told", role: "status", hidden: true });

export function showTooltip(lines, event) {
  tooltip.hidden = !lines;
  if (!lines) return;
  tooltip.replaceChildren(make("b", {}, lines[0]), ...lines.slice(1).map((line) => make("div", {}, line)));
  const { innerWidth } = window;
  const wide = tooltip.offsetWidth;
  tooltip.style.left = `${Math.min(event.clientX + 14, innerWidth - wide - 8)}px`;
  tooltip.style.top = `${event.clientY + 16}px`;
}
