//! Devices, features, limits and the validation layer itself.

use super::*;

#[test]
fn a_masked_feature_is_unsupported() {
    let error = try_context(&[Feature::MeshShader], &[Feature::MeshShader]).err().unwrap();
    assert_eq!(error.exit_code(), 77);
    assert!(error.to_string().contains("lacks mesh"), "{error}");
}

#[test]
fn an_optional_feature_is_enabled_only_if_asked_for() {
    let desc = ContextDesc {
        validation: Validation::Sync,
        selector: Some("llvmpipe"),
        optional: &[Feature::MeshShader, Feature::GeometryShader],
        masked: &[Feature::GeometryShader],
        ..ContextDesc::default()
    };
    let ctx = Context::new(&desc).unwrap();
    assert_eq!(ctx.enabled_features(), [Feature::MeshShader]);
    assert!(ctx.has(Feature::MeshShader) && !ctx.has(Feature::SamplerAnisotropy));
    assert_clean(ctx);
}

#[test]
fn of_alternatives_one_is_enabled() {
    let both = &[Feature::MeshShader, Feature::GeometryShader];
    for (masked, optional, enabled) in [
        (&[][..], &[][..], &[Feature::MeshShader][..]),
        (&[Feature::MeshShader], &[], &[Feature::GeometryShader]),
        (both, &[], &[]),
        (&[], &[Feature::GeometryShader], &[Feature::GeometryShader]),
    ] {
        let (validation, selector) = (Validation::Sync, Some("llvmpipe"));
        let desc = ContextDesc { validation, selector, optional, masked, alternatives: both, ..ContextDesc::default() };
        let ctx = Context::new(&desc).unwrap();
        assert_eq!(ctx.enabled_features(), enabled);
        assert_clean(ctx);
    }
}

#[test]
fn a_selector_that_fits_nothing_lists_the_devices() {
    let desc = ContextDesc { selector: Some("voodoo2"), ..ContextDesc::default() };
    let error = Context::new(&desc).err().unwrap();
    assert_eq!(error.exit_code(), 77);
    let text = error.to_string();
    assert!(text.contains("voodoo2") && text.contains("llvmpipe"), "{text}");
}

#[test]
fn every_device_is_reported() {
    let devices = list_devices(Validation::Off, &[]).unwrap();
    let lavapipe = devices.iter().find(|d| d.name.contains("llvmpipe")).unwrap();
    assert_eq!((lavapipe.kind, &lavapipe.rejected), ("cpu", &None));
    assert!(lavapipe.features.contains(&(Feature::MeshShader, true)), "{lavapipe:?}");
}

#[test]
fn a_wrong_call_is_caught() {
    let ctx = context(&[]);
    let usage = vk::BufferUsageFlags::TRANSFER_DST;
    let desc = BufferDesc { name: "target only", size: 64, usage, location: MemoryLocation::GpuOnly };
    let buffer = Buffer::new(&ctx, &desc).unwrap();
    // A source without TRANSFER_SRC usage: an error of the core checks.
    run_once(&ctx, |cmd| {
        cmd.copy_buffer(&buffer, 0, &buffer, 32, 32);
        Ok(())
    })
    .unwrap();
    let messages = ctx.validation_messages();
    assert!(messages.iter().any(|m| m.contains("VUID-") && m.contains("target only")), "{messages:?}");
    assert_eq!(ctx.check_validation().unwrap_err().exit_code(), 1);
}

#[test]
fn a_missing_barrier_is_caught() {
    let ctx = context(&[]);
    let usage = vk::BufferUsageFlags::TRANSFER_DST;
    let desc = BufferDesc { name: "written twice", size: 64, usage, location: MemoryLocation::GpuOnly };
    let buffer = Buffer::new(&ctx, &desc).unwrap();
    run_once(&ctx, |cmd| {
        cmd.fill_buffer(&buffer, 1);
        cmd.fill_buffer(&buffer, 2);
        Ok(())
    })
    .unwrap();
    let messages = ctx.validation_messages();
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD-WRITE-AFTER-WRITE")), "{messages:?}");
}

#[test]
fn an_image_above_the_limit_is_unsupported() {
    let ctx = context(&[]);
    let extent = [ctx.max_image_2d() + 1, 1];
    let error = Image::new(&ctx, &ImageDesc { name: "too wide", extent, ..ImageDesc::default() }).err().unwrap();
    assert_eq!(error.exit_code(), 77);
    assert!(error.to_string().contains("too wide"), "{error}");
    assert_clean(ctx);
}

#[test]
fn equal_samplers_are_one() {
    let ctx = context(&[]);
    let trilinear = SamplerDesc::default();
    let clamped = SamplerDesc { wrap: [vk::SamplerAddressMode::CLAMP_TO_EDGE; 2], ..trilinear };
    assert_eq!(Sampler::new(&ctx, &trilinear).unwrap(), Sampler::new(&ctx, &trilinear).unwrap());
    assert_ne!(Sampler::new(&ctx, &trilinear).unwrap(), Sampler::new(&ctx, &clamped).unwrap());
    assert_clean(ctx);
}

#[test]
fn a_lost_device_is_told_with_its_last_pass() {
    let ctx = context(&[]);
    for name in ["surface", "shell"] {
        run_once(&ctx, |cmd| {
            cmd.region(name, |_| ());
            Ok(())
        })
        .unwrap();
    }
    let told = ctx.failure("waiting for frame 7", vk::Result::ERROR_DEVICE_LOST).to_string();
    assert!(told.starts_with("waiting for frame 7: the device was lost"), "{told}");
    assert!(told.contains("the last pass recorded for it: shell"), "{told}");
    let other = ctx.failure("waiting for frame 7", vk::Result::ERROR_OUT_OF_HOST_MEMORY).to_string();
    assert!(!other.contains("shell"), "{other}");
    assert_clean(ctx);
}
