// The colours of lines, light and dark; a page opens in the theme of the browser, or in that of its link: #theme=dark
const palettes = {
  light: ["#0b6bcb", "#d9480f", "#2b8a3e", "#7048e8", "#c2255c", "#0c8599", "#a86a00", "#495057"],
  dark: ["#5aa9f7", "#ff8a4c", "#69c97a", "#a98bff", "#f27a9d", "#3fc1d0", "#e0b04a", "#aab2bd"],
};
const theme = () => document.documentElement.dataset.theme;
const hue = i => palettes[theme()][i % 8];
const asked = new URLSearchParams(location.hash.slice(1));
document.documentElement.dataset.theme = asked.get("theme") ?? (window.matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
