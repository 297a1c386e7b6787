import { token } from '../api/server';
import { byId } from '../dom';
import { saidNothing } from './alert';

/** The field for a token: shown when the server asks for one, or by its button afterwards. */
export function setUpToken(given: () => void): void {
  const form = byId<HTMLFormElement>('token'), field = byId<HTMLInputElement>('token-value'), open = byId<HTMLButtonElement>('token-open');
  const show = () => {
    form.hidden = false;
    open.hidden = false;
    field.focus();
  };
  open.hidden = !token.get();
  open.onclick = show;
  document.addEventListener('burnish-token', show);
  form.onsubmit = (event) => {
    event.preventDefault();
    token.set(field.value.trim());
    field.value = '';
    form.hidden = true;
    saidNothing();
    given();
  };
}
