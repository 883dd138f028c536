// Sliders: which pictures, where they meet, how large.
for (const slider of document.querySelectorAll(".slider")) {
  const stage = slider.querySelector(".stage");
  const range = slider.querySelector("input");
  const move = () => stage.style.setProperty("--at", range.value + "%");
  range.addEventListener("input", move);
  move();
  for (const choice of slider.querySelectorAll("select[data-side]")) {
    const image = slider.querySelector(`img[data-side=${choice.dataset.side}]`);
    const show = () => { image.src = pictures[choice.value]; image.alt = choice.value; };
    choice.addEventListener("change", show);
    show();
  }
  const zoom = slider.querySelector("select[data-zoom]");
  zoom.addEventListener("change", () => {
    const width = getComputedStyle(slider).getPropertyValue("--w");
    stage.style.width = zoom.value ? width * zoom.value + "px" : "";
  });
}
