// The order of the page's parts in its text, which Tab and screen readers follow, is the one that is seen at each width.

const NARROW = "(max-width: 1020px)", TELEPHONE = "(max-width: 560px)";

// Keep the order, also when the window changes; on a telephone the plot comes before its buttons.
export function followWidth(root, part) {
  const narrow = matchMedia(NARROW), telephone = matchMedia(TELEPHONE);
  const find = (selector) => root.querySelector(selector);
  const bar = find(".bar"), buttons = find(".bar .buttons"), tools = find(".tools"), controls = find(".controls"), centre = find(".centre");
  const arrange = () => {
    const focused = document.activeElement;
    if (narrow.matches) centre.after(controls);
    else centre.before(controls);
    if (telephone.matches) part("table").before(tools, buttons);
    else {
      bar.append(buttons);
      centre.prepend(tools);
    }
    if (focused !== document.activeElement && root.contains(focused)) focused.focus();
  };
  for (const query of [narrow, telephone]) query.addEventListener("change", arrange);
  arrange();
}

// Mark a box whose contents go on beside its right edge.
export function followOverflow(box) {
  const mark = () => box.toggleAttribute("data-more", box.scrollLeft + box.clientWidth < box.scrollWidth - 2);
  box.addEventListener("scroll", mark);
  new ResizeObserver(mark).observe(box);
  new ResizeObserver(mark).observe(box.firstElementChild);
}
