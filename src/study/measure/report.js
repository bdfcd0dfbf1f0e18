// Without scripts, a render and the reference stand side by side, and there is no slider.
document.documentElement.classList.add("js");
document.addEventListener("input", (event) => {
    const slide = event.target.closest(".slide");
    if (slide) slide.style.setProperty("--at", event.target.value + "%");
});
