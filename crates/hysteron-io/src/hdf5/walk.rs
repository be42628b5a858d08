//! Contents of the groups of a file.

use std::collections::HashSet;

use hdf5_reader::Dataset;
use hdf5_reader::attribute_api::Attribute;
use hdf5_reader::error::Error;
use hdf5_reader::group::Group;

use super::matlab::References;
use super::number::kind;
use crate::columns::Kind;
use crate::container::{HeldArray, MAX_ARRAYS, MOST_PATH_BYTES};

/// Groups, structures and cells within one another.
pub(super) const MOST_DEPTH: usize = 32;

/// Traversal of the groups of a file.
pub(super) struct Walk<'a> {
    /// Targets of the references in cells and structures, in a file of MATLAB.
    pub references: Option<&'a References>,
    held: Vec<HeldArray>,
    /// One an array; `None` where no dataset is read.
    datasets: Vec<Option<Dataset>>,
    /// Addresses of the datasets.
    known: HashSet<u64>,
    /// Addresses of the enclosing groups and cells, to detect cyclic links.
    around: Vec<u64>,
    /// Groups and references visited so far.
    visits: usize,
}

impl<'a> Walk<'a> {
    /// The arrays of a file, and the dataset of each that is read.
    pub fn through(
        root: &Group,
        references: Option<&'a References>,
    ) -> Result<(Vec<HeldArray>, Vec<Option<Dataset>>), Error> {
        let mut walk = Walk {
            references,
            held: Vec::new(),
            datasets: Vec::new(),
            known: HashSet::new(),
            around: Vec::new(),
            visits: 0,
        };
        walk.members(root, "")?;
        Ok((walk.held, walk.datasets))
    }

    /// Adds the contents of a group; `path` with the separator behind it.
    fn members(&mut self, group: &Group, path: &str) -> Result<(), Error> {
        self.visit()?;
        let (groups, datasets) = group.members()?;
        self.around.push(group.address());
        let mut of_elements = Vec::new();
        for dataset in datasets {
            match self.references.and_then(|references| references.of_structures(&dataset)) {
                // The fields of an array of structures are added below, element by element.
                Some(elements) => of_elements.push((dataset.name().to_owned(), elements?)),
                None => self.dataset(&dataset, path, dataset.name())?,
            }
        }
        self.structures(path, &of_elements)?;
        // MATLAB keeps the contents of its cells in #refs#, and its objects in #subsystem#.
        let is_own = |group: &&Group| !(self.references.is_some() && group.name().starts_with('#'));
        for inner in groups.iter().filter(is_own).collect::<Vec<_>>() {
            self.group(inner, path, inner.name())?;
        }
        self.around.pop();
        Ok(())
    }

    /// Adds a group by its name.
    pub fn group(&mut self, group: &Group, path: &str, name: &str) -> Result<(), Error> {
        if self.around.contains(&group.address()) {
            return Ok(());
        }
        if self.is_deep(path, name)? {
            return Ok(());
        }
        if let Some(references) = self.references
            && let Some(found) = references.other_than_structure(group)?
        {
            return self.push(None, HeldArray::new(path, name, Vec::new(), Kind::Other(found)));
        }
        let separator = if self.references.is_some() { "." } else { "/" };
        check_length(path, name)?;
        self.members(group, &format!("{path}{name}{separator}"))
    }

    /// Adds a dataset by its name.
    pub fn dataset(&mut self, dataset: &Dataset, path: &str, name: &str) -> Result<(), Error> {
        let name = name.trim_start_matches('/');
        if let Some(references) = self.references {
            if let Some(cells) = references.of_cells(dataset) {
                return self.cells(dataset, path, name, &cells?);
            }
            return self.push(Some(dataset.clone()), references.held(dataset, path, name)?);
        }
        let shape = shape(dataset);
        let held = HeldArray::new(path, name, shape, kind(dataset.dtype()));
        self.push(Some(dataset.clone()), HeldArray { unit: unit(&dataset.attributes()), ..held })
    }

    /// Adds the targets of the cells of an array.
    fn cells(&mut self, array: &Dataset, path: &str, name: &str, cells: &[u64]) -> Result<(), Error> {
        if self.is_deep(path, name)? {
            return Ok(());
        }
        self.around.push(array.address());
        for (index, &address) in cells.iter().enumerate() {
            self.follow(address, path, &format!("{name}{{{}}}", index + 1))?;
        }
        self.around.pop();
        Ok(())
    }

    /// Adds the fields of an array of structures, structure by structure; `path` with the separator behind
    /// it.
    fn structures(&mut self, path: &str, fields: &[(String, Vec<u64>)]) -> Result<(), Error> {
        let count = fields.iter().map(|(_, elements)| elements.len()).max().unwrap_or(0);
        let array = path.strip_suffix('.').unwrap_or(path);
        for index in 0..count {
            let one = if count == 1 { path.to_owned() } else { format!("{array}({}).", index + 1) };
            for (name, elements) in fields {
                if let Some(&address) = elements.get(index) {
                    self.follow(address, &one, name)?;
                }
            }
        }
        Ok(())
    }

    /// Adds the target of a reference.
    fn follow(&mut self, address: u64, path: &str, name: &str) -> Result<(), Error> {
        self.visit()?;
        check_length(path, name)?;
        let Some(references) = self.references else { return Ok(()) };
        if self.around.contains(&address) {
            let kind = Kind::Other("a reference to an enclosing group or cell array".to_owned());
            return self.push(None, HeldArray::new(path, name, Vec::new(), kind));
        }
        if let Some(dataset) = references.datasets.get(&address) {
            self.dataset(dataset, path, name)
        } else if let Some(group) = references.groups.get(&address) {
            self.group(group, path, name)
        } else {
            let kind = Kind::Other("a reference to nothing".to_owned());
            self.push(None, HeldArray::new(path, name, Vec::new(), kind))
        }
    }

    /// Whether a group or an array of cells is nested too deeply to be read; it is then listed as such.
    fn is_deep(&mut self, path: &str, name: &str) -> Result<bool, Error> {
        if self.around.len() <= MOST_DEPTH {
            return Ok(false);
        }
        let kind = Kind::Other(format!("a group deeper than the {MOST_DEPTH} levels that are read"));
        self.push(None, HeldArray::new(path, name, Vec::new(), kind))?;
        Ok(true)
    }

    fn push(&mut self, dataset: Option<Dataset>, held: HeldArray) -> Result<(), Error> {
        check_length("", &held.path)?;
        // One more than a file may have is refused later.
        if self.held.len() <= MAX_ARRAYS {
            let is_alias = dataset.as_ref().is_some_and(|dataset| !self.known.insert(dataset.address()));
            self.held.push(HeldArray { is_alias, ..held });
            self.datasets.push(dataset);
        }
        Ok(())
    }

    /// Counts a group or a reference.
    fn visit(&mut self) -> Result<(), Error> {
        self.visits += 1;
        if self.visits > MAX_ARRAYS {
            return Err(Error::ResourceLimit(format!("it holds more than {MAX_ARRAYS} groups")));
        }
        Ok(())
    }
}

/// Dimensions of a dataset, the last varying fastest.
pub(super) fn shape(dataset: &Dataset) -> Vec<usize> {
    dataset.shape().iter().map(|&n| usize::try_from(n).unwrap_or(usize::MAX)).collect()
}

/// Text of an attribute.
pub(super) fn text(attributes: &[Attribute], name: &str) -> Option<String> {
    let named = attributes.iter().find(|attribute| attribute.name.eq_ignore_ascii_case(name));
    named.and_then(|attribute| attribute.read_string().ok())
}

/// Unit by the attributes of a dataset.
pub(super) fn unit(attributes: &[Attribute]) -> Option<String> {
    ["unit", "units", "unit_string"].into_iter().find_map(|name| text(attributes, name))
}

/// Rejects overlong paths, which each of very many datasets would store.
fn check_length(path: &str, name: &str) -> Result<(), Error> {
    let is_short = path.len() + name.len() <= MOST_PATH_BYTES;
    let problem = || Error::ResourceLimit(format!("it has a path of more than {MOST_PATH_BYTES} bytes"));
    is_short.then_some(()).ok_or_else(problem)
}
