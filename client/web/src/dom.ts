/** Small help with the document. */

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found as T;
}

type Children = (Node | string | null | undefined)[];

/** An element with its properties; names with "-" and "role" are attributes. */
export function element<Name extends keyof HTMLElementTagNameMap>(
  name: Name, properties: Record<string, unknown> = {}, ...children: Children
): HTMLElementTagNameMap[Name] {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (key.includes('-') || key === 'role' || key === 'for') node.setAttribute(key, String(value));
    else (node as unknown as Record<string, unknown>)[key] = value;
  }
  node.append(...children.filter((child): child is Node | string => child !== null && child !== undefined));
  return node;
}

/** Copies text and says so on the button for a moment. */
export async function copyFrom(button: HTMLButtonElement, text: string): Promise<void> {
  const was = button.textContent;
  try {
    await navigator.clipboard.writeText(text);
    button.textContent = 'Copied';
  } catch { // no clipboard without https
    const area = element('textarea', { value: text, className: 'sr-only' });
    document.body.append(area);
    area.select();
    button.textContent = document.execCommand('copy') ? 'Copied' : 'Cannot copy';
    area.remove();
    button.focus();
  }
  setTimeout(() => { button.textContent = was; }, 1600);
}

/** Hands a file to the browser's downloads. */
export function save(content: Blob, name: string): void {
  const link = element('a', { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
