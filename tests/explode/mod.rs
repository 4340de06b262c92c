//! Parts, splitters, forces.
