import { Problem } from '../api/server';
import { byId } from '../dom';

const box = byId('alert');
byId<HTMLButtonElement>('alert').querySelector('button')!.onclick = () => { box.hidden = true; };

export function say(sentence: string): void {
  box.querySelector('p')!.textContent = sentence;
  box.hidden = false;
  box.scrollIntoView({ block: 'nearest' });
}

export const saidNothing = () => { box.hidden = true; };

/** Any failure as a sentence; a cancelled one is none. */
export function sayWhy(error: unknown, what: string): void {
  if (error instanceof DOMException && error.name === 'AbortError') return;
  const words = error instanceof Error ? error.message : String(error);
  const sentence = words.charAt(0).toUpperCase() + words.slice(1) + (/[.!?]$/.test(words) ? '' : '.');
  say(what ? `${what}: ${sentence.charAt(0).toLowerCase()}${sentence.slice(1)}` : sentence);
  if (error instanceof Problem && error.status === 401) document.dispatchEvent(new CustomEvent('burnish-token'));
}
