// Several attempts at one goal: the picture of each one's end, and the page of the one that is chosen.
const frame = document.getElementById('attempt');
const choices = [...document.querySelectorAll('#attempts button')];
const shown = choices.filter(choice => choice.dataset.page !== '');
choices.filter(choice => choice.dataset.page === '').forEach(choice => { choice.disabled = true; });
shown.forEach(choice => {
  const end = REPORT.ends[choice.dataset.page];
  makeScene(choice.querySelector('svg'), end.scene).move(end.pose, end.angles);
  choice.addEventListener('click', () => open(choice));
});
function open(choice) {
  shown.forEach(other => other.setAttribute('aria-pressed', other === choice));
  frame.srcdoc = REPORT.pages[choice.dataset.page];
}
open(shown[shown.length - 1]);
