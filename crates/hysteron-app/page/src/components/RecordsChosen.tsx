// Records chosen for an operation: a list or check boxes, so that it can be done by key.
import type { RecordEntry } from '../api/types';
import { fileName } from '../format';

/** One record of a list. */
export function RecordChosen(props: {
  label: string;
  records: RecordEntry[];
  /** What stands in the list for none of them. */
  none?: string;
  chosen: string;
  choose: (id: string) => void;
}) {
  return (
    <label class="row">
      <span class="soft">{props.label}</span>
      <select value={props.chosen} onChange={(event) => props.choose(event.currentTarget.value)}>
        {props.none && <option value="">{props.none}</option>}
        {props.records.map((one) => (
          <option key={one.id} value={one.id}>
            {one.id}
          </option>
        ))}
      </select>
    </label>
  );
}

export function RecordsChosen(props: {
  label: string;
  records: RecordEntry[];
  chosen: string[];
  choose: (ids: string[]) => void;
}) {
  const toggle = (id: string): void =>
    props.choose(
      props.chosen.includes(id) ? props.chosen.filter((other) => other !== id) : [...props.chosen, id],
    );
  return (
    <fieldset class="f">
      <legend>{props.label}</legend>
      <div class="row wrap">
        {props.records.map((record) => (
          <label class="row" key={record.id}>
            <input
              type="checkbox"
              checked={props.chosen.includes(record.id)}
              onChange={() => toggle(record.id)}
            />
            {fileName(record.id)}
          </label>
        ))}
      </div>
    </fieldset>
  );
}
