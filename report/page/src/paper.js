// Charts are drawn anew for paper, as wide as its text, so that their letters are as large. Before they are, the page
// is made that wide; main.js then draws everything.
const root = document.documentElement;
addEventListener("beforeprint", () => root.classList.add("paper"));
addEventListener("afterprint", () => root.classList.remove("paper"));
