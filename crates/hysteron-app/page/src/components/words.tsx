// Words in their places: heads, tags, findings, numbers, errors, boxes that wait.
import type { ComponentChildren } from 'preact';
import { useEffect } from 'preact/hooks';
import type { Complaint } from '../api/client';
import type { Finding as Said, Problem } from '../api/types';
import { prose } from '../format';
import { Icon, type IconName } from './icon';

export function Head({
  title,
  question,
  children,
}: {
  title: string;
  question: string;
  children?: ComponentChildren;
}) {
  useEffect(() => {
    document.title = `${title} · hysteron`;
  }, [title]);
  return (
    <div class="head">
      <div>
        <h1 tabIndex={-1}>{title}</h1>
        <p>{question}</p>
      </div>
      <div class="acts">{children}</div>
    </div>
  );
}

export function Tag({ kind = '', children }: { kind?: string; children: ComponentChildren }) {
  return <span class={`tag ${kind}`}>{children}</span>;
}

/** Where data come from; never left to colour. */
export function Origin({ simulated }: { simulated: boolean }) {
  return simulated ? <Tag kind="sim">simulated</Tag> : <Tag>measured</Tag>;
}

export type FindingKind = 'note' | 'good' | 'warn' | 'bad' | 'next';
const SIGNS: Record<FindingKind, [IconName, string]> = {
  note: ['info', 'Note: '],
  good: ['ok', 'Good: '],
  warn: ['warn', 'Warning: '],
  bad: ['bad', 'Error: '],
  next: ['next', 'Next: '],
};

/** A conclusion with its reason; its kind is an icon and a word, not a colour alone. */
export function Finding(props: {
  kind: FindingKind;
  children: ComponentChildren;
  actions?: ComponentChildren;
}) {
  const [icon, word] = SIGNS[props.kind];
  return (
    <div class={`find ${props.kind}`}>
      <Icon name={icon} />
      <div>
        <span class="vh">{word}</span>
        {props.children}
      </div>
      {props.actions && <div class="a">{props.actions}</div>}
    </div>
  );
}

/** A finding of the library. */
export function LibraryFinding({ finding }: { finding: Said }) {
  const kind = { verdict: 'note', advice: 'next', warning: 'warn' }[finding.kind] as FindingKind;
  return (
    <Finding kind={kind}>
      <b>{capital(finding.topic)}:</b> <Prose text={finding.text} />
    </Finding>
  );
}

/** A sentence of the library; what it sets in backticks is code. */
export function Prose({ text }: { text: string }) {
  const parts = prose(capital(text)).split('`');
  return (
    <>
      {parts.map((part, i) => (i % 2 === 1 && i < parts.length - 1 ? <code key={i}>{part}</code> : part))}
    </>
  );
}

/** An error where the result would have stood. */
export function Failure({
  problem,
  actions,
}: {
  problem: Problem | Complaint;
  actions?: ComponentChildren;
}) {
  // Most messages name the place themselves.
  const where = problem.where?.split(' (')[0];
  const place = where && !problem.what.includes(where) ? ` (${problem.where})` : '';
  return (
    <>
      <Finding kind="bad" actions={actions}>
        <b>
          <Prose text={problem.what} />
          {place}
        </b>
        {problem.do && (
          <p>
            <Prose text={problem.do} />
          </p>
        )}
      </Finding>
      {'around' in problem && problem.around && problem.around.length > 0 && (
        <div>
          <div class="ph">
            <h2>Around the error</h2>
          </div>
          <pre tabIndex={0} aria-label="Lines around the error">
            {problem.around.map((line) => (
              <span key={line.number} class={line.here ? 'here' : undefined}>
                {`${line.number}  ${line.text}\n`}
              </span>
            ))}
          </pre>
        </div>
      )}
    </>
  );
}

export interface Quantity {
  label: string;
  value: string;
  unit?: string;
  note?: string;
}

/** At most four numbers, each with its unit and what it means. */
export function Numbers({ list }: { list: Quantity[] }) {
  return (
    <dl class={`nums n${list.length}`}>
      {list.map((number) => (
        <div key={number.label}>
          <dt>{number.label}</dt>
          <dd>
            <b>
              {number.value}
              <small>{number.unit}</small>
            </b>
            <em>{number.note}</em>
          </dd>
        </div>
      ))}
    </dl>
  );
}

/** A box of the size of what will stand there, and what it waits for. */
export function Waiting({ height, text }: { height: number; text?: string }) {
  const style = { height: `${height}px` };
  if (!text) return <span class="sk" style={style} aria-hidden="true" />;
  return (
    <div class="awaits" style={style}>
      {text}
    </div>
  );
}

/** A room that lacks something: what, why, and the way to it. */
export function Lacking({
  title,
  children,
  action,
}: {
  title: string;
  children: ComponentChildren;
  action?: ComponentChildren;
}) {
  return (
    <div class="center">
      <div class="card">
        <h2>{title}</h2>
        <p class="soft gap">{children}</p>
        {action}
      </div>
    </div>
  );
}

export function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
