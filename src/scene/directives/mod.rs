//! The directives of a scene file: conversion of parameters to parts of the model.

mod bump;
pub(in crate::scene) mod camera;
mod emission;
pub(in crate::scene) mod film;
pub(in crate::scene) mod light;
pub(in crate::scene) mod light_image;
pub(in crate::scene) mod material;
pub(in crate::scene) mod medium;
pub(in crate::scene) mod object;
pub(in crate::scene) mod option;
pub(in crate::scene) mod shape;
pub(in crate::scene) mod state;
pub(in crate::scene) mod texture;
pub(in crate::scene) mod transform;
