//! Shaders without a device: valid, within WebGPU's defaults, and of one mind with us about every struct.

use naga::front::wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use swellcast::backend::{Gpu, Storage};

fn modules() -> Vec<(String, naga::Module)> {
    let of = |storage| {
        Gpu::shaders(storage).into_iter().map(move |(label, source)| {
            let module = wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{label}: {}", e.emit_to_string(&source)));
            (format!("{label} ({storage:?})"), module)
        })
    };
    of(Storage::F32).chain(of(Storage::F16)).collect()
}

#[test]
fn every_shader_is_valid_without_any_optional_feature() {
    for (label, module) in modules() {
        // Packing two 16-bit floats into a word is in WebGPU itself; 16-bit arithmetic, which is not, isn't used.
        let allowed = Capabilities::SHADER_FLOAT16_IN_FLOAT32;
        let checked = Validator::new(ValidationFlags::all(), allowed).validate(&module);
        assert!(checked.is_ok(), "{label}: {}", checked.unwrap_err().into_inner());
    }
}

#[test]
fn every_kernel_keeps_to_the_default_limits() {
    for (label, module) in modules() {
        assert_eq!(module.entry_points.len(), 1, "{label}");
        let size = module.entry_points[0].workgroup_size;
        assert!(size.iter().product::<u32>() <= 256, "{label}: {size:?}");
        let mut layouter = naga::proc::Layouter::default();
        layouter.update(module.to_ctx()).unwrap();
        let held = module.global_variables.iter().filter(|(_, v)| v.space == naga::AddressSpace::WorkGroup);
        let bytes: u32 = held.map(|(_, v)| layouter[v.ty].size).sum();
        assert!(bytes <= 16_384, "{label}: {bytes} bytes of workgroup storage");
        let bound = module.global_variables.iter().filter(|(_, v)| v.binding.is_some()).count();
        assert!(bound <= 8, "{label}: {bound} buffers");
    }
}

#[test]
fn numbers_are_the_same_on_both_sides() {
    let mut found = std::collections::BTreeSet::new();
    for (label, module) in modules() {
        for (_, constant) in module.constants.iter() {
            let name = constant.name.clone().unwrap_or_default();
            let Some((_, value)) = Gpu::shared_numbers().iter().find(|(shared, _)| *shared == name) else { continue };
            let naga::Expression::Literal(naga::Literal::U32(got)) = module.global_expressions[constant.init] else {
                panic!("{name} of {label} is no u32");
            };
            assert_eq!(got, *value, "{name} of {label}");
            found.insert(name);
        }
    }
    assert_eq!(found.len(), Gpu::shared_numbers().len(), "only {found:?} are declared");
}

#[test]
fn structs_have_the_members_that_they_are_filled_with() {
    let mut found = std::collections::BTreeSet::new();
    for (label, module) in modules() {
        for (_, ty) in module.types.iter() {
            let (Some(name), naga::TypeInner::Struct { members, .. }) = (&ty.name, &ty.inner) else { continue };
            let Some((_, words)) = Gpu::shared_structs().iter().find(|(shared, _)| shared == name) else { continue };
            let got: Vec<_> = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect();
            let want: Vec<_> = words.iter().enumerate().map(|(i, w)| ((*w).to_owned(), 4 * i as u32)).collect();
            assert_eq!(got, want, "{name} of {label}");
            found.insert(name.clone());
        }
    }
    assert_eq!(found.len(), Gpu::shared_structs().len(), "only {found:?} are declared");
}
