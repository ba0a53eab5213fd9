"""Results as pictures, reports and live views."""
