// @ts-check
// Runs before anything is drawn, so that at night no white page flashes. Not a module: modules come too late.
(() => {
  const stored = localStorage.getItem("timonel.palette");
  const known = stored !== null && ["bright", "day", "dusk", "night"].includes(stored);
  document.documentElement.dataset.obcTheme = known ? stored : matchMedia("(prefers-color-scheme: dark)").matches ? "dusk" : "day";
})();
