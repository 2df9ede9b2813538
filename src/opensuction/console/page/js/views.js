// The views: which there are, what each needs, and where it is. A module exports
// mount(root, context) -> unmount; its words are js/text/<name>.js, its styles css/<name>.css.
// Each is loaded when it is first opened, so that one that is broken takes no other with it.

export const VIEWS = [
  { name: "bedside", right: "see-bedside", load: () => import("./bedside/view.js") },
  { name: "setup", right: "see-bedside", load: () => import("./setup/view.js"), isOwn: true },
  { name: "signals", right: "see-signals", load: () => import("./signals/view.js"), isOwn: true },
  { name: "history", right: "see-history", load: () => import("./history/view.js"), isOwn: true },
  { name: "people", right: "sign-in", load: () => import("./account/view.js") },
];

/** The view that the address names; the bedside where it names none. */
export function viewOf(hash) {
  const name = hash.replace(/^#\/?/, "").split(/[/?]/)[0];
  return VIEWS.find((view) => view.name === name) || VIEWS[0];
}
