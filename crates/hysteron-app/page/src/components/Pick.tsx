// A row of a ranking that can be picked, by its radio button or anywhere in it; the pick is in the address.
import type { ComponentChildren } from 'preact';
import { settle } from '../route';

export function PickRow(props: {
  name: string;
  pick: string | null;
  disabled?: boolean;
  children: ComponentChildren;
}) {
  const { name, pick, disabled, children } = props;
  const choose = (): void => settle({ pick: name });
  return (
    <tr class={`click ${name === pick ? 'sel' : ''}`} onClick={choose}>
      <td>
        <label class="row">
          <input type="radio" name="pick" checked={name === pick} disabled={disabled} onChange={choose} />
          <span>{spaced(name)}</span>
        </label>
      </td>
      {children}
    </tr>
  );
}

/** The name of a structure with spaces, so that it breaks into lines. */
export const spaced = (name: string): string => name.replace(/\+/g, ' + ');
