pub(super) fn recognises(_: &[u8]) -> bool {
    false
}
pub(super) fn read(_: &[u8]) -> Result<crate::MeshDescription, super::Problem> {
    unreachable!()
}
