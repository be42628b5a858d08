//! Values of a channel, gathered from all segments of a TDMS file.

use super::number::{DataType, Timestamp};
use super::segment::{Contents, Layout, Rest, Segment};

/// Values of a channel of numbers as the file has them; of timestamps, seconds since the first.
pub(super) fn raw_values(file: &[u8], contents: &Contents, object: usize) -> Vec<f64> {
    let mut values = Vec::new();
    let mut first_time = None;
    let mut layout_index = None;
    let mut place = None;
    for segment in &contents.segments {
        let Some(layout) = contents.layouts.get(segment.layout) else { continue };
        if layout_index != Some(segment.layout) {
            place = layout.place(object);
            layout_index = Some(segment.layout);
        }
        if let Some(place) = place {
            let rest = segment.rest.and_then(|rest| contents.rests.get(rest)?.get(place).copied());
            each_value(file, layout, segment, (place, rest.unwrap_or_default()), &mut |data_type, bytes| {
                values.push(match data_type {
                    DataType::Timestamp => {
                        let time = Timestamp::new(bytes, segment.big_endian);
                        time.since(*first_time.get_or_insert(time))
                    }
                    _ => data_type.value(bytes, segment.big_endian),
                });
            });
        }
    }
    values
}

/// Calls `take` with the bytes of each value of a channel in one segment, whose incomplete last chunk has
/// `rest`.
fn each_value(
    file: &[u8],
    layout: &Layout,
    segment: &Segment,
    (place, rest): (usize, Rest),
    take: &mut dyn FnMut(DataType, &[u8]),
) {
    let Some(part) = layout.parts.get(place) else { return };
    let Some(size) = part.data_type.bytes() else { return };
    let data = file.get(segment.start..).and_then(|data| data.get(..segment.bytes)).unwrap_or_default();
    if segment.interleaved {
        let offset = part.offset_in_row as usize;
        let rows = data.chunks_exact(layout.row_bytes.max(1));
        rows.filter_map(|row| row.get(offset..offset + size)).for_each(|bytes| take(part.data_type, bytes));
        return;
    }
    let block = |start: usize, values: u64| {
        let bytes = usize::try_from(values).ok().and_then(|values| values.checked_mul(size));
        let block = data.get(start..).zip(bytes).and_then(|(data, bytes)| data.get(..bytes));
        block.unwrap_or_default().chunks_exact(size)
    };
    let (chunks, chunk_bytes) = (layout.chunks(segment) as usize, layout.chunk_bytes as usize);
    for chunk in 0..chunks {
        let start = chunk * chunk_bytes + part.offset as usize;
        block(start, part.values).for_each(|bytes| take(part.data_type, bytes));
    }
    let last = (chunks * chunk_bytes).saturating_add(rest.offset as usize);
    block(last, rest.values).for_each(|bytes| take(part.data_type, bytes));
}
