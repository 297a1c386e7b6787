import { byId } from '../dom';

/** The line between before and after: drag it, or use the arrow keys. */
export function setUpDivider(moved: (share: number) => void): { set: (share: number) => void } {
  const divider = byId('divider'), stage = byId('stage');
  let share = 0.5;
  const set = (to: number) => {
    share = Math.max(0, Math.min(1, to));
    divider.style.left = `${share * 100}%`;
    divider.setAttribute('aria-valuenow', String(Math.round(share * 100)));
    divider.setAttribute('aria-valuetext', `${Math.round(share * 100)}% before, ${100 - Math.round(share * 100)}% after`);
    moved(share);
  };
  divider.addEventListener('pointerdown', (event) => {
    divider.setPointerCapture(event.pointerId);
    event.preventDefault();
    divider.focus();
  });
  divider.addEventListener('pointermove', (event) => {
    if (!divider.hasPointerCapture(event.pointerId)) return;
    const box = stage.getBoundingClientRect();
    set((event.clientX - box.left) / box.width);
  });
  divider.addEventListener('keydown', (event) => {
    const step = event.shiftKey ? 0.1 : 0.02;
    const to: Record<string, number> = { ArrowLeft: share - step, ArrowDown: share - step, ArrowRight: share + step, ArrowUp: share + step, PageDown: share - 0.1, PageUp: share + 0.1, Home: 0, End: 1 };
    if (!(event.key in to)) return;
    set(to[event.key]);
    event.preventDefault();
  });
  set(0.5);
  return { set };
}
