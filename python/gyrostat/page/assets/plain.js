// The colours of the figures follow the theme; nothing else moves on this page.
const setTheme = name => {
  const root = document.documentElement;
  root.dataset.theme = name;
  palettes[name].forEach((tint, i) => root.style.setProperty(`--hue${i}`, tint));
};
setTheme(theme());
document.getElementById("theme").onclick = () => setTheme(theme() === "dark" ? "light" : "dark");
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", event => setTheme(event.matches ? "dark" : "light"));
document.documentElement.dataset.ready = "yes";
