// Dark or light: as the device is set, until somebody chooses; kept on this device.

const KEY = "opensuction-theme";
const dark = matchMedia("(prefers-color-scheme: dark)");

function chosen() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null; // no storage: as the device is set
  }
}

/** Which it is now. */
export function theme() {
  return chosen() || (dark.matches ? "dark" : "light");
}

/** Show it; called once at the start, and whenever the device's setting changes. */
export function applyTheme(onchange = () => {}) {
  const apply = () => {
    document.documentElement.dataset.theme = theme();
    onchange(theme());
  };
  dark.addEventListener("change", apply);
  apply();
}

/** The other one from now on. */
export function switchTheme() {
  const other = theme() === "dark" ? "light" : "dark";
  try {
    localStorage.setItem(KEY, other);
  } catch {
    // Without storage the choice lasts as long as the page.
  }
  document.documentElement.dataset.theme = other;
  dispatchEvent(new Event("themechange"));
  return other;
}
