for (const slider of document.querySelectorAll(".wipe input")) {
  const show = () => {
    slider.parentElement.style.setProperty("--at", `${slider.value}%`);
    slider.setAttribute("aria-valuetext", `${Math.round(slider.value)} percent drawn`);
  };
  slider.addEventListener("input", show);
  show(); // a browser may keep the place of a slider over a reload
}
