// A table of texts.

import { element } from "../controls.js";

/**
 * @param {string[]} head
 * @param {string[][]} rows
 */
export function table(head, rows) {
  const line = (kind, texts) => element("tr", {}, ...texts.map(text => element(kind, { text })));
  return element("table", {}, line("th", head), ...rows.map(row => line("td", row)));
}
