//! Classes of MATLAB 7.3 in HDF5. The elements of a cell array, and the fields of an array of structures, are
//! references to datasets and groups in `#refs#`.

use std::collections::HashMap;

use hdf5_reader::Dataset;
use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::messages::datatype::Datatype;
use hdf5_reader::reference::read_object_references;

use super::number::{kind, numbers};
use super::walk::{shape, text, unit};
use crate::columns::Kind;
use crate::container::{HeldArray, MAX_ARRAYS, shape_of_texts};

/// Classes of arrays that are read as what their datasets hold.
const NUMBERS: [&str; 11] =
    ["double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "logical"];
/// Most dimensions of an empty array that are shown.
const MOST_DIMENSIONS: u64 = 32;

/// Datasets and groups of `#refs#`, by address.
#[derive(Default)]
pub(super) struct References {
    pub datasets: HashMap<u64, Dataset>,
    pub groups: HashMap<u64, Group>,
    offset_bytes: u8,
}

impl References {
    /// Datasets and groups in `#refs#` of a file.
    pub fn new(root: &Group) -> Result<Self, Error> {
        let mut references = References { offset_bytes: root.offset_size(), ..References::default() };
        let (names, _) = root.member_names()?;
        if names.iter().any(|name| name == "#refs#") {
            let (groups, datasets) = root.group("#refs#")?.members()?;
            references.groups = groups.into_iter().map(|group| (group.address(), group)).collect();
            references.datasets = datasets.into_iter().map(|dataset| (dataset.address(), dataset)).collect();
        }
        Ok(references)
    }

    /// Addresses that the cells of an array refer to; `None` for another dataset.
    pub fn of_cells(&self, dataset: &Dataset) -> Option<Result<Vec<u64>, Error>> {
        let class = text(&dataset.attributes(), "MATLAB_class")?;
        (class == "cell").then(|| self.of(dataset))?
    }

    /// Addresses that a field of a structure array refers to, element by element; `None` for another dataset.
    pub fn of_structures(&self, dataset: &Dataset) -> Option<Result<Vec<u64>, Error>> {
        let is_classless = text(&dataset.attributes(), "MATLAB_class").is_none();
        is_classless.then(|| self.of(dataset))?
    }

    /// The references of a dataset.
    fn of(&self, dataset: &Dataset) -> Option<Result<Vec<u64>, Error>> {
        let Datatype::Reference { .. } = dataset.dtype() else { return None };
        Some(dataset.num_elements().and_then(|count| {
            if count > MAX_ARRAYS as u64 {
                return Err(Error::ResourceLimit(format!("it holds more than {MAX_ARRAYS} arrays")));
            }
            read_object_references(&dataset.read_raw_bytes()?, self.offset_bytes)
        }))
    }

    /// Description of a group that is not a structure with fields; `None` for one that is.
    pub fn other_than_structure(&self, group: &Group) -> Result<Option<String>, Error> {
        let attributes = group.attributes()?;
        let class = text(&attributes, "MATLAB_class");
        if attributes.iter().any(|attribute| attribute.name == "MATLAB_sparse") {
            return Ok(Some("sparse matrix".to_owned()));
        }
        match class.as_deref() {
            Some("function_handle") => Ok(Some("function".to_owned())),
            Some("struct") if group.member_names()? == (Vec::new(), Vec::new()) => {
                Ok(Some("structure without fields".to_owned()))
            }
            Some("struct") | None => Ok(None),
            Some(class) => Ok(Some(format!("object of class {class}"))),
        }
    }

    /// A dataset by its class.
    pub fn held(&self, dataset: &Dataset, path: &str, name: &str) -> Result<HeldArray, Error> {
        let attributes = dataset.attributes();
        let class = text(&attributes, "MATLAB_class");
        let mut shape = shape(dataset);
        shape.reverse();
        let is_empty = attributes.iter().any(|attribute| {
            attribute.name == "MATLAB_empty" && attribute.read_as_f64().is_ok_and(|empty| empty != 0.0)
        });
        let other = |what: &str| Kind::Other(what.to_owned());
        let kind = match class.as_deref() {
            // Its numbers are the lengths of the array.
            _ if is_empty => {
                let lengths = if dataset.num_elements()? <= MOST_DIMENSIONS {
                    numbers(&dataset.read_native_bytes()?, dataset.dtype())
                } else {
                    Vec::new()
                };
                shape = lengths.into_iter().map(|length| length as usize).collect();
                other("an empty array")
            }
            Some("char") => {
                shape = shape_of_texts(&shape);
                other("text")
            }
            Some("cell") => other("cells"),
            Some("function_handle") => other("function"),
            Some(class) if !NUMBERS.contains(&class) => Kind::Other(format!("object of class {class}")),
            _ => kind(dataset.dtype()),
        };
        Ok(HeldArray { unit: unit(&attributes), row_major: false, ..HeldArray::new(path, name, shape, kind) })
    }
}
