// All words of the page, by section. A view's section is loaded with the view, so that one that is
// broken takes no other with it.
import account from "./text/account.js";
import alarm from "./text/alarm.js";
import bedside from "./text/bedside.js";
import shell from "./text/shell.js";

export const text = { account, alarm, bedside, shell };

/** Take a view's section in, where it has one that is not here yet. */
export async function loadText(section) {
  if (!(section in text)) text[section] = (await import(`./text/${section}.js`)).default;
}

/** A sentence with its places filled in: fill("{n} left", {n: 3}). */
export function fill(sentence, values) {
  return sentence.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? values[name] : whole));
}
