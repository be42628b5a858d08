
// Buttons that copy a table and save a figure, and the mark of the section in view. Nothing leaves the page.
(() => {
  "use strict";
  const button = (text, parent, action) => {
    const node = document.createElement("button");
    node.type = "button";
    node.textContent = text;
    node.addEventListener("click", () => action(node));
    parent.appendChild(node);
    return node;
  };
  const tools = (after) => {
    const box = document.createElement("div");
    box.className = "tools";
    after.appendChild(box);
    return box;
  };
  const tell = (node, text) => {
    const before = node.textContent;
    node.textContent = text;
    node.disabled = true;
    setTimeout(() => { node.textContent = before; node.disabled = false; }, 1500);
  };

  // The clipboard is closed to some pages opened as a file: there the older way is left.
  const copy = async (text) => {
    try {
      await navigator.clipboard.writeText(text);
      return true;
    } catch {
      const area = document.createElement("textarea");
      area.value = text;
      document.body.appendChild(area);
      area.select();
      const done = document.execCommand("copy");
      area.remove();
      return done;
    }
  };
  for (const table of document.querySelectorAll("[data-csv]")) {
    button("Copy as CSV", tools(table), async (node) => {
      tell(node, (await copy(table.dataset.csv)) ? "Copied" : "The browser refused");
    });
  }

  const save = (blob, name) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  };
  // The drawing as it stands, zoomed or not, in the colours of paper: those of its attributes.
  const drawing = (svg) => {
    const own = svg.cloneNode(true);
    own.querySelectorAll(".catch,.pick,.readout,.reset").forEach((node) => node.remove());
    for (const node of [own, ...own.querySelectorAll("*")]) {
      for (const { name } of [...node.attributes]) if (name === "class" || name.startsWith("data-")) node.removeAttribute(name);
    }
    const paper = document.createElementNS(own.namespaceURI, "rect");
    for (const [name, value] of [["width", "100%"], ["height", "100%"], ["fill", "#fff"]]) paper.setAttribute(name, value);
    own.insertBefore(paper, own.querySelector("title").nextSibling);
    return new Blob([new XMLSerializer().serializeToString(own)], { type: "image/svg+xml" });
  };
  const raster = async (svg) => {
    const address = URL.createObjectURL(drawing(svg)), picture = new Image(), { width, height } = svg.viewBox.baseVal;
    picture.src = address;
    await picture.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [2 * width, 2 * height];
    canvas.getContext("2d").drawImage(picture, 0, 0, canvas.width, canvas.height);
    URL.revokeObjectURL(address);
    return new Promise((done) => canvas.toBlob(done));
  };
  for (const figure of document.querySelectorAll("figure")) {
    const svg = figure.querySelector("svg.figure"), box = tools(figure);
    const name = svg.querySelector("title").textContent.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "").slice(0, 48) || "figure";
    button("Save as PNG", box, async () => save(await raster(svg), name + ".png"));
    button("SVG", box, () => save(drawing(svg), name + ".svg"));
  }

  // What scrolls sideways can be reached by the keyboard.
  const boxes = [...document.querySelectorAll(".wide,.drawing")];
  const reach = () => boxes.forEach((box) => (box.scrollWidth > box.clientWidth + 1 ? box.setAttribute("tabindex", "0") : box.removeAttribute("tabindex")));
  addEventListener("resize", reach);
  reach();

  const links = [...document.querySelectorAll("nav.side a")];
  if (links.length) {
    const sections = links.map((link) => document.querySelector(link.hash));
    const mark = () => {
      const above = sections.filter((section) => section.getBoundingClientRect().top < 120).length;
      links.forEach((link, i) => (i === Math.max(0, above - 1) ? link.setAttribute("aria-current", "true") : link.removeAttribute("aria-current")));
    };
    addEventListener("scroll", mark, { passive: true });
    mark();
  }
  for (const list of document.querySelectorAll("details.above")) {
    list.addEventListener("click", (event) => { if (event.target.closest("a")) list.open = false; });
  }
})();
