// Requests to the server this page came from.

import { begin, type Begun } from './requests';

export interface Complaint {
  what: string;
  where?: string | null;
  expected?: string | null;
  do?: string | null;
}

export class Refusal extends Error {
  constructor(
    readonly status: number,
    readonly complaint: Complaint,
  ) {
    super(complaint.what);
  }
}

const ROOT = 'api/v1/';

/** `records`, then identifiers as one path segment each. */
export function path(...segments: string[]): string {
  return segments.map(encodeURIComponent).join('/');
}

export function query(values: Record<string, string | number | boolean | null | undefined>): string {
  const list = new URLSearchParams();
  for (const [key, value] of Object.entries(values)) if (value != null) list.set(key, String(value));
  const text = list.toString();
  return text ? `?${text}` : '';
}

export function href(resource: string): string {
  return ROOT + resource;
}

async function refusal(response: Response): Promise<Refusal> {
  const body = (await response.json().catch(() => null)) as { error?: Complaint } | null;
  return new Refusal(response.status, body?.error ?? { what: `the server answered ${response.status}` });
}

/** What a request that was stopped ends with. */
export const STOPPED: Complaint = { what: 'It was stopped.' };

async function send(
  method: string,
  resource: string,
  body?: BodyInit,
  type?: string,
  begun: Begun = begin(resource),
): Promise<Response> {
  const headers: Record<string, string> = { 'X-Request': begun.name };
  if (type) headers['Content-Type'] = type;
  try {
    const response = await fetch(ROOT + resource, { method, body, headers, signal: begun.signal });
    if (!response.ok) throw await refusal(response);
    // The body is read before the request counts as answered.
    const bytes = await response.blob();
    return new Response(response.status === 204 ? null : bytes, response);
  } catch (error) {
    if (error instanceof Refusal) throw error;
    if (begun.signal.aborted) throw new Refusal(0, STOPPED);
    throw new Refusal(0, {
      what: 'The server does not answer.',
      do: 'Start `hysteron app` again; the page goes on by itself.',
    });
  } finally {
    begun.end();
  }
}

export async function get<T>(resource: string, begun?: Begun): Promise<T> {
  return (await send('GET', resource, undefined, undefined, begun)).json() as Promise<T>;
}

export async function change<T>(
  method: 'POST' | 'PATCH' | 'DELETE',
  resource: string,
  body?: unknown,
  begun?: Begun,
): Promise<T> {
  const text = body === undefined ? undefined : JSON.stringify(body);
  const type = text === undefined ? undefined : 'application/json';
  const response = await send(method, resource, text, type, begun);
  const answer = await response.text();
  return (answer ? JSON.parse(answer) : undefined) as T;
}

/** Sends a file whole; `progress` gets the share that has been sent. */
export function upload<T>(resource: string, file: Blob, progress: (share: number) => void): Promise<T> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', ROOT + resource);
    request.setRequestHeader('Content-Type', 'application/octet-stream');
    request.upload.onprogress = (event) => event.total && progress(event.loaded / event.total);
    request.onerror = () =>
      reject(new Refusal(0, { what: 'The file could not be sent: the server does not answer.' }));
    request.onload = () => {
      let body: { error?: Complaint } | null = null;
      try {
        body = JSON.parse(request.responseText);
      } catch {
        body = null;
      }
      if (request.status >= 200 && request.status < 300) resolve(body as T);
      else
        reject(
          new Refusal(request.status, body?.error ?? { what: `the server answered ${request.status}` }),
        );
    };
    request.send(file);
  });
}
